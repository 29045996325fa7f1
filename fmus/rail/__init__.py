"""The rail: modal state space in four directions, and the rigid rail."""
