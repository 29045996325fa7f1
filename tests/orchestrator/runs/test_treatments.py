"""Treatments on a run: damping by label reaches the parameters of the FMUs, rails come by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from fmus.modal.component import structure
from fmus.packaging.build import build_fmu
from fmus.packaging.target import default_target
from fmus.rail.track_data import TRACKS
from fmus.wheel.class158 import class158
from orchestrator.errors import InputError
from orchestrator.fmi.instance import open_fmu
from orchestrator.runs.treatments import damping_values
from orchestrator.system import kept as kept_structures
from orchestrator.system.cases import find_system
from orchestrator.system.kept import rail_key, rail_named
from orchestrator.system.settable import labels_of


def test_labels_stand_in_the_descriptions() -> None:
    fmu = open_fmu(find_system("case1").elements["wheel"].source)
    labels = labels_of(fmu)
    assert "(3,0) cosine" in labels
    assert fmu.variables["damping_ratio_001"].description == f"damping ratio of mode 1, {labels[0]}"


def test_an_array_has_the_labels_of_its_modes(tmp_path: Path) -> None:
    """The same labels from an FMU of FMI 3.0, whose damping ratios are one array."""
    target = replace(default_target(), fmi=3)
    fmu = tmp_path / "wheel.fmu"
    modes = class158().modes
    build_fmu(structure("wheel", "a wheel", modes), fmu, target)
    assert labels_of(open_fmu(fmu)) == list(modes.labels)


def test_rules_become_damping_ratios() -> None:
    """Both families of a label; a factor of every mode, of what was set before; another component's modes."""
    labels = labels_of(open_fmu(find_system("case1").elements["wheel"].source))
    places = [i for i, label in enumerate(labels) if label in {"(3,0) cosine", "(3,0) sine"}]
    names = [f"damping_ratio_{i + 1:03d}" for i in places]
    found = damping_values("case1", {}, {"contact": {"mu0": 0.3}}, ["(3,0)=1e-3", "wheel=x2", "rail:lat 1=0.5"])
    assert [found["wheel"][name] for name in names] == [2e-3, 2e-3]
    assert len(found["wheel"]) == len(labels)
    assert list(found["rail"].values()) == [0.5]
    assert found["contact"] == {"mu0": 0.3}


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        ("(9,9)=1e-3", r"no mode is called \(9,9\); the labels are "),
        ("bogie:(3,0)=1", "there is no component bogie; has contact, rail, wheel"),
        ("contact=x2", "contact shows no modes"),
        ("(3,0)", "must be LABEL=RATIO"),
    ],
)
def test_a_rule_that_means_nothing_is_refused(rule: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        damping_values("case1", {}, {}, [rule])


def test_a_rail_by_name_is_built_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A track of two directions' worth of work is fitted the first time, and found the second."""
    assert rail_named("my.fmu") == Path("my.fmu")
    with pytest.raises(InputError, match=r"rail none: neither an .fmu, a track file nor one of bs113a, default"):
        rail_named("none")
    monkeypatch.setattr(kept_structures, "cache_folder", lambda kind: tmp_path / kind)
    kept = tmp_path / "rails"
    kept.mkdir()
    key = rail_key(TRACKS / "slab.toml")
    (kept / f"slab-{key}.fmu").write_bytes(b"built before")
    assert rail_named("slab").read_bytes() == b"built before"
