"""What can be computed at a point: growth rates, limit cycles, a simulated run."""
