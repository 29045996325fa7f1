"""Time signals in, numbers out; knows no files."""
