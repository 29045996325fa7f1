"""`info --set`: what can be set, as a list and as a table by mode."""

from __future__ import annotations

from pathlib import Path

from orchestrator.commands.systems.info import _settable
from orchestrator.system.inspection import settable_in


def test_what_can_be_set_has_units_ranges_and_labels_of_modes(native: Path) -> None:
    variables = settable_in(native / "wheel.fmu")
    by_name = {v["name"]: v for v in variables}
    ratio = by_name["wheel.damping_ratio_001"]
    assert (ratio["unit"], float(ratio["minimum"])) == ("1", 0.0)
    assert ratio["description"].startswith("damping ratio of mode 1, ")
    assert "wheel.v_lat" not in by_name
    table = _settable(variables, "title")
    names = list(table.columns[0].cells)
    assert names.count("wheel.*_001") == 1
    assert "wheel.damping_ratio_001" not in names
    assert len(names) < len(variables) / 5


def test_arrays_of_fmi_3_are_listed_by_element(native3: Path) -> None:
    names = [v["name"] for v in settable_in(native3 / "wheel.fmu")]
    assert "wheel.damping_ratio[1]" in names
