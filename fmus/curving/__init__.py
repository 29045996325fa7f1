"""A bogie in a curve: radius, speed, cant and friction in, the operating point of each of its four contacts out."""
