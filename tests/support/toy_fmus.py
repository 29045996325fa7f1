"""Small PythonFMU FMUs that misbehave on purpose, built for tests of the master."""

from __future__ import annotations

import hashlib
import textwrap
from pathlib import Path

from pythonfmu.builder import FmuBuilder

SLAVE = """
import ctypes
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

# PythonFMU 0.7.0 releases this namespace once per instance without owning it
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class {name}(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u = 0.0
        self.y = 0.0
        self.p = 1.0
        self.steps = 0
        self.register_variable(Real("u", causality=Fmi2Causality.input, start=0.0))
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        fixed = Fmi2Variability.fixed
        self.register_variable(Real("p", causality=Fmi2Causality.parameter, variability=fixed, start=1.0))

    def to_xml(self, model_options=None):
        root = super().to_xml(model_options or {{}})
        if {feedthrough}:
            for unknown in root.iter("Unknown"):
                unknown.set("dependencies", "1")
        return root

    def do_step(self, current_time, step_size):
        self.steps += 1
{body}
        return True
"""


def toy_fmu(folder: Path, name: str, body: str, feedthrough: bool = False) -> Path:
    """Build an FMU with an input `u`, an output `y` and a parameter `p`; `body` is what a step does.

    With `feedthrough` the model description says that `y` depends on `u` within a step.
    """
    unique = f"{name}_{hashlib.sha256(str(folder).encode()).hexdigest()[:8]}"  # all FMUs share sys.modules
    script = folder / f"{unique}.py"
    script.write_text(
        SLAVE.format(name=unique, feedthrough=feedthrough, body=textwrap.indent(textwrap.dedent(body).strip(), " " * 8))
    )
    return Path(FmuBuilder.build_FMU(script, dest=folder, needsExecutionTool=False))


def toy_ssd(folder: Path, first: Path, second: Path, unit: str = "", extra: str = "") -> Path:
    """Write an SSD that couples two toys in a ring."""
    kind = f'<ssc:Real unit="{unit}"/>' if unit else "<ssc:Real/>"
    component = """
      <ssd:Component name="{name}" source="{source}">
        <ssd:Connectors>
          <ssd:Connector name="u" kind="input"><ssc:Real/></ssd:Connector>
          <ssd:Connector name="y" kind="output">{kind}</ssd:Connector>
        </ssd:Connectors>
      </ssd:Component>"""
    both = component.format(name="a", source=first.name, kind=kind)
    both += component.format(name="b", source=second.name, kind=kind)
    path = folder / "ring.ssd"
    path.write_text(f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name="ring">
  <ssd:System name="root">
    <ssd:Elements>{both}
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startElement="a" startConnector="y" endElement="b" endConnector="u"/>
      <ssd:Connection startElement="b" startConnector="y" endElement="a" endConnector="u">{extra}</ssd:Connection>
    </ssd:Connections>
  </ssd:System>
  <ssd:DefaultExperiment startTime="0" stopTime="0.01"/>
</ssd:SystemStructureDescription>
""")
    return path
