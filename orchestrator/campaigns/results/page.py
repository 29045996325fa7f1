"""A map as a page to zoom and hover: a map in, one HTML file without anything from elsewhere out."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

import numpy as np

from .maps import Map

_LIBRARY = Path(__file__).parents[2] / "report" / "templates" / "plotly-basic.min.js"

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<style>body {{ font: 15px system-ui, sans-serif; margin: 2em auto; max-width: 60em; color: #1b1b1b; background: #fff }}
#map {{ height: 36em }} dt {{ font-weight: bold }}</style></head><body>
<h1>{title}</h1>
<p>{words}. Point at a cell for its numbers; drag to zoom, double-click to go back.</p>
<div id="map" role="img" aria-label="{words}"></div>
<details><summary>The plan</summary><pre>{plan}</pre></details>
<script>{library}</script>
<script>
(window.Plotly || window.moduleName).newPlot("map", {traces}, {layout}, {{responsive: true, displaylogo: false}})
</script></body></html>
"""


def write_page(the_map: Map, title: str, plan: str, path: Path) -> None:
    """Write the page."""
    traces, layout = figure(the_map)
    words = f"{the_map.words[:1].upper()}{the_map.words[1:]} over {the_map.x.name} and {the_map.y.name}"
    page = _PAGE.format(
        title=html.escape(title),
        words=html.escape(words, quote=True),
        plan=html.escape(json.dumps(json.loads(plan), indent=1)),
        library=_LIBRARY.read_text(encoding="utf-8"),
        traces=_script(traces),
        layout=_script(layout),
    )
    path.write_text(page, encoding="utf-8")


def _script(data: Any) -> str:
    """Return data as JSON that may stand in a script."""
    return json.dumps(data, allow_nan=False).replace("<", "\\u003c")


def figure(the_map: Map) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Return plotly traces and layout: one square marker per cell with runs."""
    rows, columns = np.nonzero(np.isfinite(the_map.value))
    value = the_map.value[rows, columns]
    x, y = (
        np.array(axis.texts)[place].tolist() if axis.texts else axis.values[place].tolist()
        for axis, place in ((the_map.x, columns), (the_map.y, rows))
    )
    unit = f" {the_map.unit}" if the_map.unit not in ("", "1") else ""
    hover = [
        f"{v:.4g}{unit}, {n} run{'s' if n > 1 else ''}" for v, n in zip(value, the_map.runs[rows, columns], strict=True)
    ]
    if the_map.low is not None and the_map.high is not None:
        ends = zip(hover, the_map.low[rows, columns], the_map.high[rows, columns], strict=True)
        hover = [f"{text}, 95 %: {low:.3g} to {high:.3g}" for text, low, high in ends]
    largest = float(np.abs(value).max(initial=1e-12))
    signed = the_map.name == "growth_rate"
    scale = {"colorscale": "RdBu", "reversescale": False, "cmin": -largest, "cmax": largest}
    marker: dict[str, Any] = {
        "symbol": "square", "size": max(5, min(40, 420 // max(the_map.value.shape))), "color": value.tolist(),
        "colorbar": {"title": {"text": f"{the_map.name} [{the_map.unit}]"}},
        **(scale if signed else {"colorscale": "Viridis"}),
    }  # fmt: skip
    words = f"{the_map.x.name} %{{x}}<br>{the_map.y.name} %{{y}}<br>%{{text}}<extra></extra>"
    trace = {"type": "scatter", "mode": "markers", "x": x, "y": y, "text": hover, "marker": marker,
             "hovertemplate": words}  # fmt: skip
    layout = {"xaxis": {"title": {"text": the_map.x.name}}, "yaxis": {"title": {"text": the_map.y.name}},
              "dragmode": "zoom", "hovermode": "closest", "margin": {"t": 20}}  # fmt: skip
    return [trace], layout
