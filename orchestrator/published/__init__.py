"""Numbers of the paper, as printed."""
