"""What a rolling contact does, for whoever needs it: Hertz's patch, Kalker's coefficients, creep laws, friction."""
