"""Measured functions and modal data: files in, SI arrays with what was used out; one reader for rail and wheel."""
