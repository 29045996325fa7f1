"""A system whose file changes is another system: no store of the old one answers for it."""

from __future__ import annotations

import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from orchestrator.campaigns.competition import Starts, compete, competition_plan
from orchestrator.campaigns.plan import Plan
from orchestrator.campaigns.prepared import pack
from orchestrator.campaigns.sampling import points
from orchestrator.campaigns.stages import quantities
from orchestrator.campaigns.store import open_campaign, open_store
from orchestrator.campaigns.sweep import How
from orchestrator.errors import InputError
from orchestrator.runs.scenario import Scenario

PLACE = "resources/contact-case1.ssv"


def plan_of(ssp: Path) -> Plan:
    return competition_plan(Scenario(str(ssp), duration=0.003), Starts(1))


def with_friction(source: Path, target: Path, mu0: str) -> Path:
    """Write a copy of an SSP whose contact has another friction coefficient."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for entry in old.infolist():
            data = old.read(entry)
            if entry.filename == PLACE:
                more = f'<ssv:Parameter name="mu0"><ssv:Real value="{mu0}"/></ssv:Parameter></ssv:Parameters>'
                data = data.replace(b"</ssv:Parameters>", more.encode())
            new.writestr(entry, data)
    return target


def test_a_value_in_the_ssp_makes_another_campaign(built: Path, tmp_path: Path) -> None:
    """The plan's words are the same, and so are the FMUs; a copy of the file elsewhere is no change."""
    file = tmp_path / "s.ssp"
    with_friction(built / "curvesqueal.ssp", file, "0.3")
    first, _ = pack(plan_of(file))
    shutil.copy(file, tmp_path / "copy.ssp")
    assert pack(plan_of(tmp_path / "copy.ssp"))[0].system_digest == first.system_digest
    with_friction(built / "curvesqueal.ssp", file, "0.02")
    second, _ = pack(plan_of(file))
    assert first.plan.digest == second.plan.digest
    assert first.names == second.names
    assert first.digest != second.digest
    where, what = points(first.plan), quantities(first.plan)
    open_store(tmp_path / "s.zarr", first, where, what)
    with pytest.raises(InputError, match="is the store of a system with other values or connections"):
        open_store(tmp_path / "s.zarr", second, where, what)
    with pytest.raises(InputError, match="is the store of a system with other values or connections"):
        open_store(tmp_path / "s.zarr", replace(first, settings=replace(first.settings, step=1e-5)), where, what)


@pytest.mark.slow
def test_a_competition_runs_again_after_a_change_in_the_ssp(built: Path, tmp_path: Path) -> None:
    """mu0 0.3, then 0.02 under the same name, then 0.3 again: three answers, the third one from the first store."""
    file = tmp_path / "s.ssp"
    rows = []
    for mu0 in ("0.3", "0.02", "0.3"):
        with_friction(built / "curvesqueal.ssp", file, mu0)
        ended = compete(plan_of(file), tmp_path, How(workers=1))
        assert (ended.done, ended.failures) == (1, ())
        data = open_campaign(ended.store).load()
        rows.append((ended.store, str(data["identity"][0].item()), float(data["lateral_rms"][0])))
    assert rows[2] == rows[0]
    assert all(a != b for a, b in zip(rows[0], rows[1], strict=True))
