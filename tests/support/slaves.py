"""Slaves driven by FMPy's binding call by call, for tests of FMUs."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Sequence
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave, fmi3LogMessageCallback

from fmus.component import Component, Instance

NAMES = ("wheel", "rail", "rail-rigid", "contact")
H = 5e-6
CHANGES = {f"steady_creepage_{d}_change": 2e-3 for d in ("lon", "lat", "spin")} | {"mu0_change": 0.02}
HEADERS = Path(fmpy.__file__).parent / "c-code"


def binary(fmu: Path, folder: Path, place: str = "linux64") -> Path:
    """Unpack the library of a platform and return it."""
    with zipfile.ZipFile(fmu) as archive:
        name = next(n for n in archive.namelist() if n.startswith(f"binaries/{place}/"))
        return Path(archive.extract(name, folder))


def signal(component: Component, steps: int) -> np.ndarray:
    """Return inputs for a component: some tens of newtons, or some centimetres per second and micrometres."""
    names = [v.name for v in component.of("input")]
    scale = np.array([2e-6 if "_u_" in n else 0.05 if "_v_" in n else CHANGES.get(n, 50.0) for n in names])
    time = np.arange(steps)[:, None] * H
    phases = np.arange(len(names))
    return scale * np.sin(2 * np.pi * (300 + 170 * phases) * time + phases)


class Slave:
    """A slave driven by FMPy's binding, call by call."""

    def __init__(self, file: Path, parameters: dict[str, float] | None = None) -> None:
        self.folder = fmpy.extract(str(file))
        self.description = fmpy.read_model_description(self.folder)
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.slave = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="test",
        )
        self.slave.instantiate(loggingOn=True)
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        for name, value in (parameters or {}).items():
            write = self.slave.setInteger if isinstance(value, int) else self.slave.setReal
            write([self.reference[name]], [value])
        self.slave.exitInitializationMode()
        self.time = 0.0

    def names(self, causality: str) -> list[str]:
        """Return the names of one causality."""
        return [v.name for v in self.description.modelVariables if v.causality == causality]

    def set_inputs(self, values: np.ndarray) -> None:
        """Set the first inputs, in the order of the model description; the contact's motion comes first."""
        self.slave.setReal([self.reference[n] for n in self.names("input")[: values.size]], values.tolist())

    def outputs(self) -> np.ndarray:
        """Return all outputs."""
        return np.array(self.slave.getReal([self.reference[n] for n in self.names("output")]))

    def step(self) -> None:
        """Make one step."""
        self.slave.doStep(self.time, H)
        self.time += H

    def close(self) -> None:
        """Free the slave."""
        self.slave.terminate()
        self.slave.freeInstance()


class Caught(Slave):
    """A slave that keeps its messages."""

    def __init__(self, file: Path) -> None:
        self.messages: list[str] = []
        self.folder = fmpy.extract(str(file))
        self.description = fmpy.read_model_description(self.folder)
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.slave = FMU2Slave(
            guid=self.description.guid, unzipDirectory=self.folder, instanceName="test",
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )  # fmt: skip
        callbacks = fmi2CallbackFunctions()
        self.logger = fmi2CallbackLoggerTYPE(lambda _e, _n, _s, _c, m: self.messages.append(m.decode()))
        callbacks.logger = self.logger
        self.slave.instantiate(callbacks=callbacks, loggingOn=False)
        self.time = 0.0

    def start(self) -> None:
        """Initialise."""
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()


class Slave3:
    """An FMI 3.0 slave driven by FMPy's binding."""

    def __init__(self, file: Path) -> None:
        self.folder = fmpy.extract(str(file))
        self.description = fmpy.read_model_description(self.folder)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.messages: list[str] = []
        self.time = 0.0
        self.slave = FMU3Slave(
            guid=self.description.guid, unzipDirectory=self.folder, instanceName="test",
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.slave.instantiate(loggingOn=True, logMessage=self._logger())

    def _logger(self) -> object:
        self.callback = fmi3LogMessageCallback(lambda _e, _s, _c, m: self.messages.append(m.decode()))
        return self.callback

    def start(self) -> None:
        """Initialise."""
        self.slave.enterInitializationMode(startTime=0.0)
        self.slave.exitInitializationMode()

    def get(self, name: str, size: int = 1) -> np.ndarray:
        """Return a variable, as an array."""
        return np.array(self.slave.getFloat64([self.variables[name].valueReference], nValues=size))

    def set(self, name: str, values: list[float]) -> None:
        """Set a variable."""
        self.slave.setFloat64([self.variables[name].valueReference], values)

    def _references(self, causality: str) -> list[int]:
        return [v.valueReference for v in self.variables.values() if v.causality == causality]

    def set_inputs(self, values: np.ndarray) -> None:
        """Set the first inputs, in the order of the model description; the contact's motion comes first."""
        self.slave.setFloat64(self._references("input")[: values.size], values.tolist())

    def outputs(self) -> np.ndarray:
        """Return all outputs."""
        return np.array(self.slave.getFloat64(self._references("output")))

    def step(self) -> None:
        """Make one step."""
        self.slave.doStep(self.time, H)
        self.time += H

    def close(self) -> None:
        """Free the slave."""
        self.slave.freeInstance()
        shutil.rmtree(self.folder)


class InProcess:
    """The component in this process, with the manners of `Slave`."""

    def __init__(self, component: Component, parameters: dict[str, float]) -> None:
        self.instance = Instance(component, parameters)
        self.instance.initialise()

    def set_inputs(self, values: np.ndarray) -> None:
        """Set the first inputs."""
        self.instance.inputs[: values.size] = values

    def outputs(self) -> np.ndarray:
        """Return all outputs."""
        return self.instance.outputs.copy()

    def step(self) -> None:
        """Make one step."""
        self.instance.do_step(H)

    def close(self) -> None:
        """Do nothing."""


def coupled(parts: Sequence[Slave | Slave3 | InProcess], steps: int) -> np.ndarray:
    """Couple wheel, rail and contact, structures first, and return all outputs of every step."""
    wheel, rail, contact = parts
    rows = []
    for _ in range(steps):
        for slave in (wheel, rail):
            slave.step()
        w, r = wheel.outputs(), rail.outputs()
        contact.set_inputs(np.concatenate([w[0:4], r[0:4], w[5:7], r[5:7]]))
        contact.step()
        c = contact.outputs()
        wheel.set_inputs(c[0:4])
        rail.set_inputs(c[4:8])
        rows.append(np.concatenate([w, r, c]))
    return np.array(rows)


def assert_steps_as(slave: Slave, instance: Instance, steps: int) -> None:
    """Compare the outputs of an FMU with the component's, to 1e-12 of each output's largest value; close the FMU."""
    instance.initialise()
    found, expected = [slave.outputs()], [instance.outputs.copy()]
    for u in signal(instance.component, steps):
        slave.set_inputs(u)
        slave.step()
        instance.inputs[:] = u
        instance.do_step(H)
        found.append(slave.outputs())
        expected.append(instance.outputs.copy())
    slave.close()
    scale = abs(np.array(expected)).max(axis=0)
    assert (abs(np.array(found) - expected).max(axis=0) <= 1e-12 * scale).all()
