"""Friction laws of the contact: a file for each law with its slope, their parameters, and laws by name."""
