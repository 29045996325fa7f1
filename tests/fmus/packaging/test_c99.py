# mypy: disable-error-code="no-untyped-def, no-untyped-call, call-arg, assignment, index"
"""Kernels translated to C99: the same numbers as Python's, and clear words about what cannot be translated."""

from __future__ import annotations

import ctypes
import math
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from slaves import Slave, Slave3, coupled

from fmus.compile import positions
from fmus.packaging.c99.expressions import TranslationError
from fmus.packaging.c99.translator import translate

AT = positions("AT", ("first", "second"))
PLACES = (2, 0, 1)
TABLE = np.array(((1.0, -2.5, 1e-300), (0.5, 3.0, math.pi)))
LINE = np.array((0.5, -1.5))
N = 3


def _pair(x, y):
    """Return two results."""
    if x > y:
        return x, 1
    return y, 0.5


def _mixed(x, n):
    """Return a tuple of several types."""
    return (x, 2.0 * x), n, n > 1


def _fill(target, places, short):
    """Write into an array; the name `short` is a word of C."""
    for k in range(len(places)):
        target[places[k]] = short + k
    target[-1] += 1.0


def everything(parameters, derived, state, inputs, outputs, h):
    """Use all that the subset has: tuples, loops, conditions, tables, slices, whole and real numbers."""
    a, b = inputs[AT.first], inputs[AT.second]
    a, b = b, a
    count = 0
    total = 0
    for i in range(10, 0, -3):
        if i == 4:
            continue
        total += i * a
        count += 1
    while count < 20 and not (count == 7 or count > 30):
        count += 1
        if total > 1e6 or total < -1e6:
            break
    big, flag = _pair(a, b)
    both, n, more = _mixed(a, count)
    cos = math.cos(a)
    last = outputs[3:].size if more else 0
    outputs[0] = total + count // 2 + -count % 3 + i
    outputs[1] = big * flag + both[1] - both[0] ** 2 + 7 / 2 + n
    outputs[2] = min(a, b, 0.25) + max(count, 2) + abs(-count) + abs(b) + cos + LINE[1]
    for k in range(3):
        outputs[3 + k] = TABLE[k % 2, PLACES[k]] * (1.0 if 0.0 <= a < b else -1.0) + float(int(3.7 * a)) + last
    c = d = 2.0 * h
    c *= 3.0
    _fill(outputs[6:9], PLACES, c - d)
    outputs[9] = AT.second + N * math.pi - (a - (b - d)) / (1.0 + a * a)


def nothing(parameters, derived, state, inputs, outputs):
    """Do nothing."""


@pytest.fixture(scope="module")
def in_c(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    """Return `everything` compiled from its translation, without a warning."""
    folder = tmp_path_factory.mktemp("c99")
    text = translate({"initialise": nothing, "do_step": everything}, [1, 1, 1, 2, 10])
    (folder / "kernels.c").write_text(text)
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("needs cc")
    command = [compiler, "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-shared", "-fPIC"]
    subprocess.run([*command, "kernels.c", "-o", "kernels.so", "-lm"], cwd=folder, check=True, timeout=120)
    function = ctypes.CDLL(str(folder / "kernels.so")).curvesqueal_do_step
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double]

    def run(values: list[float], h: float) -> np.ndarray:
        memory = np.zeros(15)
        memory[3:5] = values
        function(None, None, memory.ctypes.data, h)
        return memory[5:]

    return run


NUMBER = st.floats(-1e6, 1e6)


@given(values=st.tuples(NUMBER, NUMBER), h=st.floats(1e-9, 1.0))
def test_the_translation_computes_what_python_computes(
    in_c: Callable[..., Any], values: tuple[float, float], h: float
) -> None:
    """To rounding of the largest term: C may call another cosine and power."""
    outputs = np.zeros(10)
    zeros = [np.zeros(1) for _ in range(3)]
    everything(*zeros, np.array(values), outputs, h)
    scale = np.array([1e3, 1.0, 10.0] + [10.0] * 7) * (1.0 + max(map(abs, values))) ** np.array([1, 2] + [1] * 8)
    assert (abs(in_c(list(values), h) - outputs) <= 4e-16 * scale).all()


def _text(parameters, derived, state, inputs, outputs):
    outputs[0] = len("text")


def _list(parameters, derived, state, inputs, outputs):
    outputs[0] = [1.0, 2.0][0]


def _other_library(parameters, derived, state, inputs, outputs):
    outputs[0] = np.sum(inputs)


def _itself(parameters, derived, state, inputs, outputs):
    _itself(parameters, derived, state, inputs, outputs)


def _two_types(parameters, derived, state, inputs, outputs):
    x = 1.0
    x = (x, x)
    outputs[0] = x[0]


def _over_items(parameters, derived, state, inputs, outputs):
    for x in inputs:
        outputs[0] = x


def _real_index(parameters, derived, state, inputs, outputs):
    outputs[inputs[0]] = 1.0


def _raises(parameters, derived, state, inputs, outputs):
    if inputs[0] < 0.0:
        raise ValueError("negative")


def _unknown(parameters, derived, state, inputs, outputs):
    outputs[0] = somewhere_else  # type: ignore[name-defined]  # noqa: F821


REFUSED = {
    _text: "'text'",
    _list: "[1.0, 2.0]",
    _other_library: "a call of np.sum",
    _itself: "this call: _itself",
    _two_types: "x, which is double and Tuple_dx2,",
    _over_items: "inputs",
    _real_index: "inputs[0], which is double here,",
    _raises: "raise ValueError('negative')",
    _unknown: "the name somewhere_else",
}


@pytest.mark.parametrize("kernel", REFUSED, ids=lambda k: k.__name__)
def test_what_cannot_be_translated_is_said_with_its_place(kernel: Any) -> None:
    first = kernel.__code__.co_firstlineno
    with pytest.raises(TranslationError, match=re.escape(f"{REFUSED[kernel]} cannot be translated to C")) as caught:
        translate({"initialise": kernel}, [1, 1, 1, 2, 10])
    where = re.search(rf"test_c99.{kernel.__name__}, line (\d+):", str(caught.value))
    assert where is not None
    assert first < int(where.group(1)) <= first + 3


@pytest.mark.parametrize(
    ("fixture", "make", "steps", "moving"),
    [
        pytest.param("native", Slave, 10_000, 5e-4, marks=pytest.mark.slow),
        pytest.param("native3", Slave3, 500, 5e-5, marks=pytest.mark.slow),
    ],
)
def test_compiled_sources_give_the_native_numbers(
    request: pytest.FixtureRequest, fixture: str, make: Any, steps: int, moving: float, tmp_path: Path
) -> None:
    """`fmpy compile` builds the sources of an FMU; Case 1 in sliding, to 1e-12 of each output's largest value.

    The two versions of FMI share the kernels, so the second one runs shorter.
    """
    if shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    folder = request.getfixturevalue(fixture)
    runs = []
    for compiled in (True, False):
        parts = []
        for name in ("wheel", "rail", "contact"):
            file = folder / f"{name}.fmu"
            if compiled:
                file = Path(shutil.copy(file, tmp_path))
                command = [sys.executable, "-m", "fmpy", "compile", str(file)]
                done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
                assert done.returncode == 0, done.stderr[-2000:]
                assert b"NATIVE_KERNELS" not in file.read_bytes()
            parts.append(make(file))
            if make is Slave3:
                parts[-1].start()
        runs.append(coupled(parts, steps))
        for part in parts:
            part.close()
    scale = abs(runs[1]).max(axis=0)
    assert scale[1] > moving  # m/s, lateral velocity of the wheel
    assert (abs(runs[0] - runs[1]).max(axis=0) <= 1e-12 * scale).all()
