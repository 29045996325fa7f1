"""Cycles against a parameter: bifurcation diagrams."""
