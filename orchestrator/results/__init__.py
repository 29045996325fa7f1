"""Results on disk: the file, its columns, other formats."""
