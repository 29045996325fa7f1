"""Data as JSON that every reader takes: a number that is not finite is null, with its reason beside it."""

from __future__ import annotations

import json
from math import isfinite
from typing import Any


def dumps(data: Any) -> str:
    """Return JSON text; `not_finite` names the places of what became null, where data is an object.

    >>> print(dumps({"a": [1.0, float("inf")], "b": 2}))
    {
     "a": [
      1.0,
      null
     ],
     "b": 2,
     "not_finite": {
      "a.1": "inf"
     }
    }
    """
    reasons: dict[str, str] = {}
    found = _finite(data, "", reasons)
    if reasons and isinstance(found, dict):
        found["not_finite"] = reasons
    return json.dumps(found, allow_nan=False, indent=1)


def _finite(data: Any, place: str, reasons: dict[str, str]) -> Any:
    if isinstance(data, dict):
        return {key: _finite(value, f"{place}.{key}".lstrip("."), reasons) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value, f"{place}.{k}".lstrip("."), reasons) for k, value in enumerate(data)]
    if isinstance(data, float) and not isfinite(data):
        reasons[place] = str(float(data))
        return None
    return data
