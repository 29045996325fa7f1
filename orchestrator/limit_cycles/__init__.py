"""Limit cycles without time integration: harmonic balance, continuation, stability, bifurcations.

A cycle is what squeal becomes: a periodic vibration of wheel and rail with the nonlinear contact. It is computed as
such, whether a run from some start would find it or not.
"""
