"""The contact: Hertz spring, FASTSIM creep forces and friction law, solved implicitly against the structures."""
