"""The house: what a newcomer relies on when looking for a thing, or adding one."""

from __future__ import annotations

import ast
import re
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import orchestrator
from orchestrator.cli import COMMANDS, RAIL_COMMANDS, WHEEL_COMMANDS

ROOT = Path(__file__).parents[2]
PACKAGES = ("fmus", "orchestrator")
FOLDERS = sorted({path.parent for package in PACKAGES for path in (ROOT / package).rglob("*.py")})
SOURCES = [path for folder in FOLDERS for path in sorted(folder.glob("*.py"))]
BELOW_COMMANDS = [p for p in SOURCES if "commands" not in p.parts and p.name != "cli.py"]
TOOLS = ROOT / "fmus/packaging/native/linker.py"
"""Speaks to compilers, whose options these are."""


def test_the_top_level_is_that_of_the_project() -> None:
    for name in ("pyproject.toml", "fmus/wheel", "fmus/rail", "fmus/contact", "orchestrator", "tests", "ssp"):
        assert (ROOT / name).exists(), name


def test_no_folder_has_more_modules_than_a_screen_shows() -> None:
    sizes = {folder.relative_to(ROOT): len(list(folder.glob("*.py"))) for folder in FOLDERS}
    assert {f: n for f, n in sizes.items() if n > 16} == {}
    assert sorted(sizes.values())[len(sizes) // 2] < 10


LONG = {
    "orchestrator/campaigns/plan.py": 330,
    "orchestrator/coupling/master.py": 325,
    "orchestrator/fmi/binding.py": 400,
    "orchestrator/system/reader.py": 340,
}
"""Modules that are still above 300 lines, and what they must not grow beyond."""


def test_no_file_is_longer_than_one_reads_at_once() -> None:
    files = [*SOURCES, *(ROOT / "tests").rglob("*.py")]
    lines = {p.relative_to(ROOT).as_posix(): p.read_text(encoding="utf-8").count("\n") for p in files}
    assert {name: n for name, n in lines.items() if n > LONG.get(name, 300)} == {}


def test_every_folder_says_what_it_is() -> None:
    for folder in FOLDERS:
        text = (folder / "__init__.py").read_text(encoding="utf-8")
        assert ast.get_docstring(ast.parse(text)), folder


def test_nothing_below_the_commands_names_an_option() -> None:
    """A library's message must make sense to who calls the library."""
    for path in BELOW_COMMANDS:
        text = path.read_text(encoding="utf-8")
        if path == TOOLS or "--" not in text:
            continue
        texts = [n.value for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Constant)]
        assert [t for t in texts if isinstance(t, str) and re.search(r"(^|[\s(`'])--[a-z]", t)] == [], path


def test_components_raise_their_own_error() -> None:
    """`DataError` is a user's mistake; a plain ValueError from these packages is a fault, and shows its traceback."""
    slave = ROOT / "fmus/packaging/python/slave.py"  # speaks FMI, where any exception is an error of the call
    plain = [p for p in SOURCES if p.parts[len(ROOT.parts)] == "fmus" and "raise ValueError(" in p.read_text()]
    assert [p for p in plain if p != slave] == []


@pytest.mark.parametrize("table", [COMMANDS, RAIL_COMMANDS, WHEEL_COMMANDS], ids=["top", "rail", "wheel"])
def test_a_command_is_a_row_and_a_file(table: dict[str, tuple[str, str]]) -> None:
    for name, (place, text) in table.items():
        module, _, function = place.partition(":")
        loaded = getattr(import_module(f"orchestrator.commands.{module}"), function or name)
        assert loaded.__doc__, place
        assert text.endswith("."), place


def test_no_two_commands_share_a_file() -> None:
    modules = [
        place.partition(":")[0] for table in (COMMANDS, RAIL_COMMANDS, WHEEL_COMMANDS) for place, _ in table.values()
    ]
    assert len(set(modules)) == len(modules)


def test_every_case_of_the_table_has_its_system_structure() -> None:
    cases = tomllib.loads((ROOT / "ssp" / "cases.toml").read_text(encoding="utf-8"))["case"]
    files = {path.stem for path in (ROOT / "ssp").glob("*.ssd")}
    assert {c["name"] for c in cases[1:]} <= files
    assert "SystemStructure" in files


def test_the_packages_are_typed_and_have_a_version() -> None:
    for package in PACKAGES:
        assert (ROOT / package / "py.typed").is_file()
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", orchestrator.__version__)
