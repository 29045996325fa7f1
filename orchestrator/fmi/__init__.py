"""One FMU: its file, its calls, its process."""
