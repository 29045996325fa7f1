"""The compiled co-simulation loop: index arrays and function addresses in, outputs out. Nothing here knows names."""
