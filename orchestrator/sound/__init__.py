"""Sound of vibration: radiated power, pressure, WAV files."""
