"""Vehicles as data: every number with unit and source, mistakes in a sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.curving.parameters import VEHICLE
from fmus.curving.vehicles import VEHICLES, read_vehicle, vehicle_names

TEXT = (VEHICLES / "reference.toml").read_text(encoding="utf-8")


def test_reference_vehicle_is_what_the_component_starts_with() -> None:
    vehicle = read_vehicle(VEHICLES / "reference.toml")
    assert vehicle.parameters == {v.name: v.start for v in VEHICLE}


@pytest.mark.parametrize("name", vehicle_names())
def test_shipped_vehicles_say_where_each_number_comes_from(name: str) -> None:
    vehicle = read_vehicle(VEHICLES / f"{name}.toml")
    assert vehicle.parameters.keys() == vehicle.sources.keys() == {v.name for v in VEHICLE}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("value = 0.42", "value = -0.42", "own.toml: wheel_radius = -0.42: must be in the range"),
        ("value = 10e6", "value = -10e6", "own.toml: primary_yaw_stiffness = -1e.07: must be in the range"),
        ('unit = "N/m"', 'unit = "kN/m"', "own.toml: primary_lateral_stiffness: unit must be 'N/m'; got 'kN/m'"),
        ("value = 1.3\n", "", "own.toml: half_wheelbase must be { value = ..., unit = ..., source = ... }"),
        ("value = 1.3", "value = true", "own.toml: half_wheelbase: value must be a number; got True"),
        ("[load_height]", "[load_hight]", "own.toml: 'load_hight' is unknown"),
        ('source = "assumed"', 'source = ""', "source must be a text"),
        ('title = "reference bogie"', "", "own.toml: title must be a text"),
        ("title =", "title", "own.toml: not a TOML file"),
    ],
)
def test_mistakes_in_a_vehicle_are_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in TEXT
    path = tmp_path / "own.toml"
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        read_vehicle(path)


def test_a_missing_number_is_named(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(TEXT[: TEXT.index("[load_height]")], encoding="utf-8")
    with pytest.raises(ValueError, match=r"own.toml: 'load_height' is missing"):
        read_vehicle(path)
