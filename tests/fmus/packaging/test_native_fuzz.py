"""Random calls with random arguments: a native FMU never crashes, and a reset always helps."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_bool, c_double, c_size_t
from pathlib import Path
from typing import Any

import fmpy
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from slaves import binary

WORDS = {2: ("Real", "Integer", "FMUstate", "DeSerialize"), 3: ("Float64", "Int32", "FMUState", "Deserialize")}
NUMBERS = st.sampled_from([0.0, 1.0, -1.0, 5e-6, 1e-3, 60e3, 1e300, -1e300, float("nan"), float("inf"), 5e-324])
REFERENCES = st.integers(0, 70) | st.sampled_from([2**31, 2**32 - 1])
METHODS = (
    *("enter", "exit", "terminate", "reset", "set_real", "set_integer", "get_real", "step", "keep", "restore"),
    *("differentiate", "serialise", "nothing"),
)
CALLS = st.lists(
    st.tuples(st.sampled_from(METHODS), st.lists(REFERENCES, max_size=4), st.lists(NUMBERS, min_size=4, max_size=4)),
    max_size=40,
)


class Raw:
    """An FMI 2 or 3 instance called through ctypes; each method takes references and numbers and returns a status."""

    def __init__(self, fmu: Path, library: Path, fmi: int) -> None:
        self.fmi = fmi
        self.library = ctypes.CDLL(str(library))
        self.real, self.integer, self.state, self.deserialise = WORDS[fmi]
        description = fmpy.read_model_description(str(fmu))
        make = self.library.fmi2Instantiate if fmi == 2 else self.library.fmi3InstantiateCoSimulation
        make.restype = ctypes.c_void_p
        token = (description.guid if fmi == 2 else description.instantiationToken).encode()
        if fmi == 2:
            self.handle = ctypes.c_void_p(make(b"x", 1, token, b"", None, 0, 0))
        else:
            no = [c_bool(False)] * 4
            self.handle = ctypes.c_void_p(make(b"x", token, b"", *no, None, c_size_t(0), None, None, None))
        assert self.handle.value
        self.kept = ctypes.c_void_p()

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function of the standard and return its status."""
        status: int = getattr(self.library, f"fmi{self.fmi}{name}")(self.handle, *arguments)
        return status

    def close(self) -> None:
        """Free the kept state and the instance."""
        self.call(f"Free{self.state}", byref(self.kept))
        getattr(self.library, f"fmi{self.fmi}FreeInstance")(self.handle)

    def enter(self, _references: list[int], numbers: list[float]) -> int:
        """Enter initialisation mode with these start and stop times."""
        start, stop, zero = c_double(numbers[0]), c_double(numbers[1]), c_double(0.0)
        if self.fmi == 3:
            return self.call("EnterInitializationMode", c_bool(False), zero, start, c_bool(True), stop)
        return self.call("SetupExperiment", 0, zero, start, 1, stop) or self.call("EnterInitializationMode")

    def exit(self, *_: Any) -> int:
        """Leave initialisation mode."""
        return self.call("ExitInitializationMode")

    def terminate(self, *_: Any) -> int:
        """Terminate."""
        return self.call("Terminate")

    def reset(self, *_: Any) -> int:
        """Reset."""
        return self.call("Reset")

    def _values(self, name: str, references: list[int], values: Any) -> int:
        count = c_size_t(len(references))
        vr = (ctypes.c_uint32 * 4)(*references)
        return self.call(name, vr, count, values, *([count] if self.fmi == 3 else []))

    def set_real(self, references: list[int], numbers: list[float]) -> int:
        """Set reals."""
        return self._values(f"Set{self.real}", references, (c_double * 4)(*numbers))

    def get_real(self, references: list[int], numbers: list[float]) -> int:
        """Get reals."""
        return self._values(f"Get{self.real}", references, (c_double * 4)(*numbers))

    def set_integer(self, references: list[int], numbers: list[float]) -> int:
        """Set integers."""
        whole = [int(x) if abs(x) < 1e9 else 7 for x in numbers]
        return self._values(f"Set{self.integer}", references, (ctypes.c_int32 * 4)(*whole))

    def nothing(self, *_: Any) -> int:
        """Ask for three variables and give no arrays."""
        return self.call(f"Get{self.real}", None, c_size_t(3), None, *([c_size_t(3)] if self.fmi == 3 else []))

    def step(self, _references: list[int], numbers: list[float]) -> int:
        """Make a step."""
        time, h = c_double(numbers[0]), c_double(numbers[1])
        if self.fmi == 2:
            return self.call("DoStep", time, h, 1)
        flags, last = (c_bool * 3)(), c_double()
        return self.call("DoStep", time, h, c_bool(True), *(byref(flags, i) for i in range(3)), byref(last))

    def keep(self, *_: Any) -> int:
        """Keep the state."""
        return self.call(f"Get{self.state}", byref(self.kept))

    def restore(self, *_: Any) -> int:
        """Go back to the kept state, if there is one."""
        return self.call(f"Set{self.state}", self.kept)

    def serialise(self, *_: Any) -> int:
        """Write the kept state to bytes and read it back."""
        size = c_size_t()
        status = self.call(f"Serialized{self.state}Size", self.kept, byref(size))
        data = (ctypes.c_char * size.value)()
        status = status or self.call(f"Serialize{self.state}", self.kept, data, size)
        return status or self.call(f"{self.deserialise}{self.state}", data, size, byref(self.kept))

    def differentiate(self, references: list[int], numbers: list[float]) -> int:
        """Ask for directional derivatives."""
        n = c_size_t(len(references))
        vr, seed, result = (ctypes.c_uint32 * 4)(*references), (c_double * 4)(*numbers), (c_double * 4)()
        if self.fmi == 2:
            return self.call("GetDirectionalDerivative", vr, n, vr, n, seed, result)
        return self.call("GetDirectionalDerivative", vr, n, vr, n, seed, n, result, n)


@pytest.fixture(scope="module", params=[(name, fmi) for name in ("wheel", "contact") for fmi in (2, 3)], ids=str)
def subject(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, int]:
    """Return an FMU, its unpacked library and its FMI version."""
    name, fmi = request.param
    fmu: Path = request.getfixturevalue("native" if fmi == 2 else "native3") / f"{name}.fmu"
    return fmu, binary(fmu, tmp_path_factory.mktemp(name), "linux64" if fmi == 2 else "x86_64-linux"), fmi


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(calls=CALLS)
def test_no_sequence_of_calls_crashes_and_reset_always_helps(subject: tuple[Path, Path, int], calls: list[Any]) -> None:
    raw = Raw(*subject)
    for method, references, numbers in calls:
        assert getattr(raw, method)(references, numbers) in (0, 3)
    for method in ("reset", "enter", "exit", "set_real", "step", "get_real"):
        assert getattr(raw, method)([1], [0.0, 5e-6, 0.0, 0.0]) == 0
    raw.close()
