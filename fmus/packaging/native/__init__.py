"""Native FMUs: kernels lowered to machine code for several platforms, and one C file with the FMI functions."""
