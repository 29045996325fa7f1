"""What a system structure says of the simulation: the default experiment, and annotations of ours and of other tools.

SSP leaves step sizes and master algorithms to annotations. Ours are in docs/conventions.md.
"""

from __future__ import annotations

from dataclasses import dataclass

from lxml import etree

from fmus.packaging.ssp.namespaces import tag

from ..errors import Fault
from .xml import SSC, SSD, Document, local

_OURS = tag("curvesqueal")
_STEPS = (
    (tag("osp", "FixedStepAlgorithm"), "baseStepSize"),
    (tag("oms", "FixedStepMaster"), "stepSize"),
)
"""Elements and attributes in which other tools keep the communication step, in the order in which they are tried."""


@dataclass(frozen=True)
class ExperimentSettings:
    """How the file wants the system simulated.

    Attributes
    ----------
    start, stop : default experiment [s]; stop None if not told
    step_size : communication step [s], None if not told
    algorithm : name of the master algorithm, None if not told
    """

    start: float = 0.0
    stop: float | None = None
    step_size: float | None = None
    algorithm: str | None = None


def read_settings(document: Document, notices: list[str]) -> ExperimentSettings:
    """Return the settings of the whole system.

    Raises
    ------
    InputError
        If an annotation of ours holds what it should not.
    """
    experiment = document.root.find(f"{SSD}DefaultExperiment")
    start, stop = 0.0, None
    if experiment is not None:
        start = document.number(experiment, "startTime", 0.0)
        stop = document.number(experiment, "stopTime", 0.0) if experiment.get("stopTime") is not None else None
    holders = [node for node in (experiment, document.root, document.root.find(f"{SSD}System")) if node is not None]
    ours = _own(document, holders, "Master", ("stepSize", "algorithm"), notices)
    for stray in document.root.iter(f"{_OURS}Master"):
        if stray is not ours:
            raise document.error(stray, "only one is read, in DefaultExperiment, at the root or in its System")
    step = None if ours is None else ours.get("stepSize")
    node = ours
    for element, attribute in _STEPS:
        if step is None:
            node = next(document.root.iter(element), None)
            step = None if node is None else node.get(attribute)
    return ExperimentSettings(
        start, stop, None if step is None else _positive(document, node, step),
        None if ours is None else ours.get("algorithm"),
    )  # fmt: skip


def read_component(
    document: Document, component: etree._Element, notices: list[str]
) -> tuple[int | None, float | None]:
    """Return the place in the order of stepping and the step [s] that an annotation gives a component, None if none."""
    ours = _own(document, [component], "Component", ("stage", "stepSize"), notices)
    if ours is None:
        return None, None
    text, step = ours.get("stage"), ours.get("stepSize")
    if text is not None and not text.isdecimal():
        raise document.error(ours, f"stage = {text!r}: must be a whole number, 0 or larger")
    return None if text is None else int(text), None if step is None else _positive(document, ours, step)


def _own(
    document: Document, holders: list[etree._Element], name: str, attributes: tuple[str, ...], notices: list[str]
) -> etree._Element | None:
    """Return our annotation of some element; an element in it that is not known is an error, an attribute is told."""
    for holder in holders:
        for annotation in holder.iterfind(f"{SSD}Annotations/{SSC}Annotation"):
            for node in annotation:
                if not node.tag.startswith(_OURS):
                    continue
                if local(node) != name or len(node):
                    raise document.error(node, f"element {local(node)!r} of the annotation is not known")
                for key in node.attrib:
                    if key not in attributes:
                        where = document.where(node)
                        notices.append(Fault(f"{where}: attribute {key!r} of the annotation is not known; passed over"))
                return node
    return None


def _positive(document: Document, node: etree._Element, text: str) -> float:
    """Return a step size."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise document.error(node, f"step size {text!r}: must be a number > 0")
    return value
