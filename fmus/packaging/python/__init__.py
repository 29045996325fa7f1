"""FMUs with a Python body, by PythonFMU."""
