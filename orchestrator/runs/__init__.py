"""A scenario from start to end, and many of them."""
