"""`python -m orchestrator` is the command line `curvesqueal`."""

from .cli import main

main()
