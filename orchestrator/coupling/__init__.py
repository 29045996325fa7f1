"""The master: systems in, stepped FMUs out."""
