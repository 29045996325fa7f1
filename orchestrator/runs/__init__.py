"""Runs: a scenario from start to end, and what identifies it."""
