"""Linear analysis: poles, eigenloci, growth rates of a scheme."""
