"""What the process of an isolated FMU answers to a call: JSON and raw bytes, checked before they are believed.

The FMU may have done anything to its process. So nothing that comes from there is unpickled, which would run what it
says, and an answer of another kind than the call has is no answer.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

FAILED = -1
"""In the place of a status: the call ended with an exception that is not FMI's."""

MOST_BYTES = 2**31 - 1
"""Longest answer; a longer one is none."""

_HEAD = struct.Struct("<4sI")
"""Mark, and length of the JSON text; what comes after the text is the state of an FMU."""

_MARK = b"fmu1"


class Answer(NamedTuple):
    """What a call came to.

    Attributes
    ----------
    status : of the FMI function, or `FAILED`
    result : what the call returned; a sentence if it failed
    messages : what the FMU said meanwhile
    """

    status: int
    result: Any
    messages: Sequence[str]


def pack(answer: Answer) -> bytes:
    """Return an answer as bytes.

    >>> unpack(pack(Answer(0, b"state", ["so"])), "serialise")
    Answer(status=0, result=b'state', messages=['so'])
    """
    raw = answer.result if isinstance(answer.result, bytes) else b""
    plain = None if isinstance(answer.result, bytes) else answer.result
    text = json.dumps([answer.status, plain, list(answer.messages)]).encode()
    return _HEAD.pack(_MARK, len(text)) + text + raw


def unpack(data: bytes, call: str) -> Answer:
    """Return the answer to a call.

    Raises
    ------
    ValueError
        If the bytes are no answer to such a call.
    """
    if len(data) < _HEAD.size:
        raise ValueError("too short")
    mark, length = _HEAD.unpack_from(data)
    if mark != _MARK or _HEAD.size + length > len(data):
        raise ValueError("no answer")
    found = json.loads(data[_HEAD.size : _HEAD.size + length])
    raw = data[_HEAD.size + length :]
    if not (isinstance(found, list) and len(found) == 3):
        raise ValueError("no answer")
    status, result, messages = found
    if not (_whole(status) and isinstance(messages, list) and all(isinstance(m, str) for m in messages)):
        raise ValueError("no answer")
    if status == FAILED:
        result = str(result)
    elif status > 1:
        result = None
    elif call == "serialise":
        result = raw
    elif not _WANTED.get(call, _nothing)(result):
        raise ValueError("another kind of answer")
    return Answer(status, result, messages)


def _whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _nothing(value: Any) -> bool:
    return value is None


def _values(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(v, (bool, int, float, str)) for v in value)


def _state(value: Any) -> bool:
    return _whole(value) and value > 0


def _step(value: Any) -> bool:
    """Return whether this is what a step returns: nothing in FMI 2.0; three flags and a time in FMI 3.0."""
    if not isinstance(value, list):
        return value is None or _whole(value)
    return len(value) == 4 and all(isinstance(v, bool) for v in value[:3]) and isinstance(value[3], (int, float))


_WANTED: Mapping[str, Callable[[Any], bool]] = {
    "get": _values,
    "get_state": _state,
    "deserialise": _state,
    "do_step": _step,
    "ended": lambda value: isinstance(value, bool),
}
"""What the calls return that return something, by name."""
