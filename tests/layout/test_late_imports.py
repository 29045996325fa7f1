"""What is imported late, and why: the one list of the imports that stand inside functions, for start-up time."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = [path for package in ("fmus", "orchestrator") for path in sorted((ROOT / package).rglob("*.py"))]

LATE = {
    "xarray": "takes a second, most of it pandas",
    "scipy.signal": "takes a second with scipy.stats",
    "soundfile": "loads a library of its own",
    "jinja2": "only pages need it",
    "pint": "slow, and most systems need no conversion of units",
    "pyarrow": "an optional dependency",
    "numba": "optional in an FMU, which runs without it, too",
    "llvmlite": "only builds need it",
    "fmus.cache": "not there in an FMU",
    "fmus.machine_code": "needs numba, which is optional in an FMU",
    "fmpy.logging": "loads a library that not every platform has",
    "fmus.sources": "not there in an FMU",
    "fmus.rail.shipped": "loads scikit-fem",
    "orchestrator.fmi.isolation": "seldom wanted",
    "orchestrator.cli": "Ctrl-C while it is being loaded ends like any other",
    "orchestrator.figures": "loads matplotlib",
}
"""What modules below the commands import late: module, reason. A command imports late whatever it alone needs."""

SHORT_RUN = (
    "xarray",
    "pandas",
    "matplotlib",
    "scipy.signal",
    "scipy.stats",
    "scipy.interpolate",
    "skfem",
    "pint",
    "dask",
)
"""What a run of a case has no use for."""


def late_imports(path: Path) -> list[str]:
    """Return the full names of the modules that a file imports inside functions."""
    text = path.read_text(encoding="utf-8")
    if "PLC0415" not in text:  # what the linter would find
        return []
    tree = ast.parse(text)
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    found = []
    for node in {id(n): n for f in functions for n in ast.walk(f)}.values():
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            package = path.relative_to(ROOT).parts[: -node.level] if node.level else ()
            base = ".".join([*package, *([node.module] if node.module else [])])
            found += [f"{base}.{alias.name}" for alias in node.names]
    return found


def test_an_import_inside_a_function_is_on_the_list_and_each_row_is_used() -> None:
    used = {name for path in SOURCES if "commands" not in path.parts for name in late_imports(path)}
    rows = {name: [late for late in LATE if f"{name}.".startswith(f"{late}.")] for name in used}
    assert {name for name, found in rows.items() if not found} == set()
    assert set(LATE) - {late for found in rows.values() for late in found} == set()


def test_a_short_run_imports_only_what_it_uses(tmp_path: Path) -> None:
    code = (
        "import json, sys\n"
        "from pathlib import Path\n"
        "import orchestrator.commands.systems.run\n"
        "from orchestrator.runs.run import Report, run_scenario\n"
        "from orchestrator.runs.scenario import Scenario\n"
        "run_scenario(Scenario('case1', duration=0.002), Path(sys.argv[1]), Report())\n"
        f"print(json.dumps([m for m in {SHORT_RUN!r} if m in sys.modules]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == []
