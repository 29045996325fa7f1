"""The master: reads a system, loads its FMUs, couples them at a fixed step, and says what came out."""
