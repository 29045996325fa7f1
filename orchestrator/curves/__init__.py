"""A bogie in a curve and what its wheels sing: between the physics of `fmus.curving` and the commands."""
