"""Finite elements of an axisymmetric wheelset: cross-section in, modes at the contact point out."""
