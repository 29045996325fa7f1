"""What a campaign says: maps, Sobol indices, tones, a page, a table."""
