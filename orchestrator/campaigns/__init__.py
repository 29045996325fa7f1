"""Campaigns: one plan in, thousands of runs on any number of machines, one store of their results out."""
