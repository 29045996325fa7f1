"""Plans of campaigns for tests."""

from __future__ import annotations

import tomllib
from pathlib import Path

from orchestrator.campaigns.plan import Plan, make_plan


def plan_of(
    vary: str, sample: str = "", compute: str = "", system: str = 'case = "case3"', folder: Path = Path()
) -> Plan:
    """Return the plan of the contents of its tables."""
    text = f"[system]\n{system}\n[vary]\n{vary}\n[sample]\n{sample}\n[compute]\n{compute}\n"
    return make_plan(tomllib.loads(text), folder)
