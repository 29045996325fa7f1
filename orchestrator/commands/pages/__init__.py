"""Commands that leave something to read or hear: report, listen, paper, table4."""
