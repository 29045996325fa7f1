"""The types of FMI 3.0 and SSP 2.0 under the names that earlier versions have, in one table."""

from __future__ import annotations

INTEGERS = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")

_PLAIN = {"Float64": "Real", "Float32": "Real", **dict.fromkeys(INTEGERS, "Integer")}


def plain_type(name: str) -> str:
    """Return the name of a type in FMI 2.0 and SSP 1.0; those that they do not know keep theirs.

    >>> plain_type("Float64"), plain_type("UInt8"), plain_type("Boolean")
    ('Real', 'Integer', 'Boolean')
    """
    return _PLAIN.get(name, name)
