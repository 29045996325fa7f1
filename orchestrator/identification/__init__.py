"""How the wheel class158 was identified from Table 4."""
