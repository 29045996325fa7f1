"""Two tones at once: quasi-periodic motion that a cycle breaks up into, by harmonic balance of two frequencies."""
