"""Names that mean something to a terminal, a picture, a page or a file system: everything shows them as they are."""

from __future__ import annotations

import html
import json
import re
import sys
import zipfile
from pathlib import Path
from urllib.parse import quote
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import pytest
from matplotlib.image import imread
from synthetic_results import STEP

from orchestrator.cli import command_line
from orchestrator.commands.tools import Screen
from orchestrator.report.page import write_report
from orchestrator.results.file import Column, ResultsFile, open_results
from orchestrator.results.layout import file_stem
from orchestrator.visible import visible

NAMES = ["a/b", "two  blanks ", "x" * 300, "[/b]", "[red]", "$\\frac", "<!--<script>", ":smile:", "&amp;", "ä\u202eb"]
IN_FILES = [*NAMES[3:], "\x1b[31mred", "\udcff.no-utf-8"]


def ids(name: str) -> str:
    return re.sub(r"\W", "_", name[:12].encode("ascii", "replace").decode())


def odd_system(block: Path, folder: Path, name: str) -> Path:
    """Write an SSD whose system, component, connected output and, where it can be, FMU file have the name."""
    file = folder / (f"{name}.fmu" if file_stem(name) == name else "block.fmu")
    with zipfile.ZipFile(block) as old, zipfile.ZipFile(file, "w") as new:
        for entry in old.infolist():
            data = old.read(entry)
            if entry.filename == "modelDescription.xml":
                data = data.replace(b'name="y"', f"name={quoteattr(name)}".encode())
            new.writestr(entry, data)
    port = '<ssd:Connector name={} kind="{}"><ssc:Real/></ssd:Connector>'
    path = folder / "system.ssd"
    path.write_text(
        f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name={quoteattr(name)}>
  <ssd:System name="root"><ssd:Elements>
    <ssd:Component name={quoteattr(name)} source="{escape(quote(file.name))}"><ssd:Connectors>
      {port.format('"u"', "input")}{port.format(quoteattr(name), "output")}
    </ssd:Connectors></ssd:Component></ssd:Elements>
  </ssd:System>
  <ssd:DefaultExperiment startTime="0" stopTime="0.01"/>
</ssd:SystemStructureDescription>
""",
        encoding="utf-8",
    )
    return path


def command(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command in this process; return what it prints without the breaks of lines."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["curvesqueal", *arguments])
        patch.setenv("COLUMNS", "1000")
        code = command_line()
    captured = capsys.readouterr()
    assert code == 0, captured.err
    assert "Traceback" not in captured.err
    return captured.out


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in ("a/b", "[/b]") else pytest.mark.slow, id=ids(n)) for n in NAMES]
)
def test_a_run_shows_the_names_that_files_give(
    tmp_path: Path, block: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    """System, component, variable and FMU file: results, CSV, JSON, table and picture have them."""
    ssd = odd_system(block, tmp_path, name)
    arguments = ("run", str(ssd), "--step", "1e-3", "--out", str(tmp_path / "r"))
    data = json.loads(command(capsys, *arguments, "--csv", "--picture", "--json"))
    results = Path(data["results"])
    assert data["case"] == name
    assert results.parent == tmp_path / "r"
    assert Path(data["picture"]).stat().st_size > 1000
    with open_results(results) as found:
        assert found.attrs["title"] == name
        signals = [v for v in found.data_vars if found[v].attrs["units"] is not None]
        assert len(signals) == 2
        assert np.isfinite(found[signals[0]].to_numpy()).all()
    assert results.with_suffix(".csv").read_text(encoding="utf-8").count("\n") == data["steps"] // 4 + 2 + 1
    printed = command(capsys, *arguments)
    second = results.with_name(f"{results.stem}-2.nc")
    assert second.is_file()
    squeezed = "".join(printed.split())
    assert "".join(visible(f"{name}: 0.01 s in 10 steps").split()) in squeezed
    assert "".join(visible(str(second)).split()) in squeezed
    shown = "".join(command(capsys, "info", str(ssd)).split())
    assert "".join(visible(name).split()) in shown


@pytest.mark.parametrize("name", [pytest.param(n, id=ids(n)) for n in (NAMES[0], *IN_FILES)])
def test_a_report_shows_titles_and_has_its_figures(tmp_path: Path, name: str) -> None:
    """The figures of the page are JSON in a script element, which no title ends or opens again."""
    path = tmp_path / f"{file_stem(name)}.nc"
    time = np.linspace(STEP, 4000 * STEP, 4000)
    signal = 0.1 * np.sin(2 * np.pi * 1000 * time)
    about: dict[str, str | float | int] = {"title": visible(name), "case": visible(name), "algorithm": "staggered"}
    about |= {"step_s": STEP, "record_every": 1}
    with ResultsFile(path, [Column(f"{b}.v_lat", "m/s", "") for b in ("wheel", "rail")], about) as file:
        file.append(time, np.column_stack([signal, 0.1 * signal]).astype(np.float64))
    page = write_report([path], tmp_path).read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="figures">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    assert "<" not in found.group(1)
    assert len(json.loads(found.group(1))) >= 3
    heading = re.search(r'<h2 id="run1">(.*?)</h2>', page)
    assert heading is not None
    assert html.unescape(heading.group(1)) == visible(name)


@pytest.mark.parametrize("name", [*NAMES, *IN_FILES[-2:]], ids=ids)
def test_a_table_shows_a_name_as_it_is(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """No markup, no emoji, nothing that steers the terminal."""
    from rich.table import Table  # noqa: PLC0415

    table = Table(name, title=name)
    table.add_row(name)
    screen = Screen(width=2000)
    screen.print(table)
    screen.print(name, soft_wrap=True)
    out = capsys.readouterr().out
    assert out.count(visible(name).strip()) == 4
    assert "\x1b" not in out


@pytest.mark.parametrize("name", [pytest.param(n, id=ids(n)) for n in (NAMES[0], *IN_FILES)])
def test_a_picture_shows_any_title(tmp_path: Path, name: str) -> None:
    from orchestrator.figures.competition import draw_competition  # noqa: PLC0415
    from orchestrator.signals.tones import tones  # noqa: PLC0415

    draw_competition(name, {"random start": tones([1100.0, None]), name: tones([1978.0])}, tmp_path / "p.png")
    assert imread(tmp_path / "p.png").shape[0] > 100
