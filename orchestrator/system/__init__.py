"""What a system is, and reading one from SSP and SSD files."""
