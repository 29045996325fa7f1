"""One FMU driven by hand: responses, mobilities, checks."""
