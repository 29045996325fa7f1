"""Kernels as C99: a translator of their typed Python, for hosts that compile FMUs themselves."""
