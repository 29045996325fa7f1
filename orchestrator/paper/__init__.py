"""The page that sets the paper next to this software."""
