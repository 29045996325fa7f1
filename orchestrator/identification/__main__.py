"""`python -m orchestrator.identification`: identify the wheel class158 anew and write its data."""

from .data import write_identification

write_identification(report=print)
