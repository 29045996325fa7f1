"""`python -m fmus.wheel.finite_elements [SECTION.toml ...]`: make the tables of modes of cross-sections anew."""

import sys

from .modes import main

main(sys.argv[1:])
