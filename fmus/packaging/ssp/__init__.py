"""Cases and components in, SSP files out."""
