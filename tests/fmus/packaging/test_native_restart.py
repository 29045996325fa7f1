"""What a host may do with time and with kept states: steps go forward, damaged bytes are refused."""

from __future__ import annotations

import ctypes
import struct
from ctypes import byref, c_bool, c_double, c_void_p
from pathlib import Path

import fmpy
import numpy as np
import pytest
from slaves import Caught, H, Slave, Slave3

LAST_SUCCESSFUL_TIME = 2
"""fmi2LastSuccessfulTime."""

ERROR = 3
"""fmi3Error."""


def stepped(file: Path, steps: int = 20) -> Caught:
    """Return a slave after some steps."""
    slave = Caught(file)
    slave.start()
    for _ in range(steps):
        slave.step()
    return slave


@pytest.mark.parametrize("back", [H, 0.5 * H, 20 * H])
def test_a_communication_point_that_jumps_back_is_refused(native: Path, back: float) -> None:
    slave = stepped(native / "rail-rigid.fmu")
    with pytest.raises(fmpy.fmi1.FMICallException):
        slave.slave.doStep(20 * H - back, H)
    assert "must not be before 0.0001 s, which is reached" in slave.messages[-1]
    slave.slave.freeInstance()


def test_rounding_of_the_time_is_no_jump_and_a_kept_state_leads_back(native: Path) -> None:
    """Hosts that add up and hosts that multiply differ by rounding; a nanosecond clock by its half."""
    slave = stepped(native / "rail-rigid.fmu")
    state = slave.slave.getFMUstate()
    for time in (np.nextafter(20 * H, 0.0), 21 * H - 0.5e-9):
        slave.slave.doStep(time, H)
    slave.slave.setFMUstate(state)
    slave.slave.doStep(20 * H, H)
    slave.slave.freeFMUstate(state)
    slave.close()


def test_after_a_failed_step_the_last_successful_time_is_that_before_it(native: Path, native3: Path) -> None:
    slave = stepped(native / "contact.fmu")
    slave.slave.setReal([slave.reference["wheel_u_lat"]], [-1e300])
    with pytest.raises(fmpy.fmi1.FMICallException):
        slave.slave.doStep(20 * H, H)
    assert slave.slave.getRealStatus(LAST_SUCCESSFUL_TIME) == pytest.approx(20 * H, rel=1e-12)
    slave.slave.freeInstance()
    third = Slave3(native3 / "contact.fmu")
    third.start()
    third.step()
    third.set("wheel_u_lat", [-1e300])
    flags, last = [c_bool(), c_bool(), c_bool()], c_double(-1.0)
    step = ctypes.CDLL(third.slave.dll._name).fmi3DoStep
    component = c_void_p(third.slave.component)
    assert step(component, c_double(H), c_double(H), c_bool(True), *map(byref, flags), byref(last)) == ERROR
    assert last.value == pytest.approx(H, rel=1e-12)
    assert not any(flag.value for flag in flags)
    third.close()


@pytest.mark.parametrize("name", ["wheel", "contact"])
def test_states_with_a_damaged_byte_are_refused(native: Path, name: str) -> None:
    """Any byte, any bit: the checksum finds every error of a single byte."""
    slave = stepped(native / f"{name}.fmu")
    state = slave.slave.getFMUstate()
    data = slave.slave.serializeFMUstate(state)
    random = np.random.default_rng(13)
    for place in random.integers(0, len(data), 400):
        damaged = bytearray(data)
        damaged[place] ^= 1 << int(random.integers(0, 8))
        with pytest.raises(fmpy.fmi1.FMICallException):
            slave.slave.deSerializeFMUstate(bytes(damaged))
        slave.slave.setFMUstate(state)
    slave.slave.deSerializeFMUstate(data)
    slave.slave.freeInstance()


def sealed(data: bytes) -> bytes:
    """Return bytes with the checksum that belongs to them: FNV-1a."""
    total = 14695981039346656037
    for byte in data:
        total = (total ^ byte) * 1099511628211 % 2**64
    return data + struct.pack("<Q", total)


@pytest.mark.parametrize(
    ("place", "value", "word"),
    [
        ("phase", struct.pack("<i", 12), "phase"),
        ("stale", struct.pack("<i", 7), "time"),
        ("last_step", struct.pack("<d", -1.0), "time"),
        ("reached", struct.pack("<d", float("nan")), "time"),
        ("input", struct.pack("<d", float("inf")), "wheel_u_lat"),
        ("parameter", struct.pack("<d", -1.0), "normal_load"),
    ],
)
def test_states_that_cannot_be_are_refused_also_with_a_checksum(
    native: Path, place: str, value: bytes, word: str
) -> None:
    slave = stepped(native / "contact.fmu")
    slave.slave.setReal([slave.reference["wheel_u_lat"]], [1.25e-7])
    slave.step()
    state = slave.slave.getFMUstate()
    body = slave.slave.serializeFMUstate(state)[:-8]
    end = len(body)
    wanted = {"stale": end - 4, "phase": end - 8, "last_step": end - 16, "reached": end - 24}
    wanted["input"] = body.index(struct.pack("<d", 1.25e-7))
    wanted["parameter"] = body.index(struct.pack("<d", 60e3))
    changed = body[: wanted[place]] + value + body[wanted[place] + len(value) :]
    assert slave.slave.deSerializeFMUstate(sealed(body)) is not None
    with pytest.raises(fmpy.fmi1.FMICallException):
        slave.slave.deSerializeFMUstate(sealed(changed))
    assert word in slave.messages[-1]
    slave.slave.freeInstance()


@pytest.mark.slow
def test_python_fmus_refuse_steps_back_and_damaged_states(built: Path) -> None:
    slave = Slave(built / "rail-rigid.fmu")
    for _ in range(3):
        slave.step()
    state = slave.slave.getFMUstate()
    data = slave.slave.serializeFMUstate(state)
    slave.slave.setFMUstate(slave.slave.deSerializeFMUstate(data))
    with pytest.raises(fmpy.fmi1.FMICallException):
        slave.slave.doStep(0.0, H)
    damaged = data[:-1] + bytes([data[-1] ^ 1])
    with pytest.raises(fmpy.fmi1.FMICallException):
        slave.slave.setFMUstate(slave.slave.deSerializeFMUstate(damaged))
    slave.slave.setFMUstate(slave.slave.deSerializeFMUstate(data))
    slave.step()
    slave.slave.freeInstance()
