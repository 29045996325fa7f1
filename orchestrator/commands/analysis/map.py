"""The command `curvesqueal map`: a store of a campaign in, maps, Sobol indices and shares of tones out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from ...errors import InputError
from ..tools import Json, screen

if TYPE_CHECKING:
    import xarray as xr

    from ...campaigns.results.maps import Map


def map(  # noqa: PLR0913, PLR0917 - one argument per option
    store: Annotated[Path, typer.Argument(metavar="STORE.zarr", help="What `sweep` wrote.")],
    x: Annotated[str | None, typer.Option("--x", help="Factor along the horizontal axis.")] = None,
    y: Annotated[str | None, typer.Option("--y", help="Factor along the vertical axis.")] = None,
    colour: Annotated[
        str, typer.Option(help="Quantity: growth_rate, tone, level, ..., or probability of squeal.")
    ] = "growth_rate",
    indices: Annotated[str | None, typer.Option(help="Sobol indices of this quantity, in place of a map.")] = None,
    tones: Annotated[bool, typer.Option("--tones", help="Probability of each tone, in place of a map.")] = False,
    out: Annotated[
        Path | None, typer.Option(help="Picture: .png, .pdf, .svg, or .html to zoom; default: .png beside the store.")
    ] = None,
    json: Json = False,
) -> None:
    """Show a campaign: a quantity over two parameters, Sobol indices, or the probability of each tone."""
    from ...campaigns.store import open_campaign  # noqa: PLC0415 - xarray takes its time

    if bool(indices) + tones + (x is not None or y is not None) != 1 or (x is None) != (y is None):
        raise InputError("map: give --x and --y, or --indices, or --tones")
    data = open_campaign(store)
    if indices is not None:
        found = _indices(data, indices, out or store.with_suffix(".indices.png"))
    elif tones:
        found = _tones(data, out or store.with_suffix(".tones.png"))
    else:
        found = _map(data, str(x), str(y), colour, out or store.with_suffix(f".{colour}.png"))
    if json:
        screen.print_json(data=found)
    else:
        screen.print(_table(found))
        screen.print(found["picture"], highlight=False, soft_wrap=True)


def _map(data: xr.Dataset, x: str, y: str, colour: str, path: Path) -> dict[str, Any]:
    """Make a map and its picture."""
    from ...campaigns.results.maps import make_map  # noqa: PLC0415
    from ...campaigns.results.page import write_page  # noqa: PLC0415

    found = make_map(data, x, y, colour)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".html":
        write_page(found, str(data.attrs["title"]), str(data.attrs["plan"]), path)
    else:
        _draw(found, str(data.attrs["title"]), _picture(path))
    return {**found.as_json(), "picture": str(path)}


def _picture(path: Path) -> Path:
    if path.suffix not in (".png", ".pdf", ".svg"):
        raise InputError(f"--out {path}: must end with .png, .pdf, .svg or, for a map, .html")
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _draw(found: Map, title: str, path: Path) -> None:
    from ...figures.campaign import Grid, draw_grid  # noqa: PLC0415 - matplotlib takes its time

    unit = {"1": "-", "s-1": "1/s"}.get(found.unit, found.unit)
    grid = Grid(
        title, found.x.name, found.y.name, f"{found.words} [{unit}]", found.x.values, found.y.values,
        found.x.texts, found.y.texts, found.value, found.name == "growth_rate",
    )  # fmt: skip
    draw_grid(grid, path)


def _indices(data: xr.Dataset, name: str, path: Path) -> dict[str, Any]:
    """Compute Sobol indices and draw them."""
    from ...campaigns.results.sobol import indices  # noqa: PLC0415
    from ...figures.campaign import Share, draw_indices  # noqa: PLC0415

    found = indices(data, name)
    draw_indices(
        f"{data.attrs['title']}: Sobol indices of {name}",
        [i.factor for i in found],
        [Share(i.first, i.first_low, i.first_high) for i in found],
        [Share(i.total, i.total_low, i.total_high) for i in found],
        _picture(path),
    )
    return {"quantity": name, "confidence": 0.95, "indices": [i.as_json() for i in found], "picture": str(path)}


def _tones(data: xr.Dataset, path: Path) -> dict[str, Any]:
    """Count the tones that the runs ended in, and draw them."""
    from ...campaigns.results.maps import ended_tones  # noqa: PLC0415
    from ...figures.competition import draw_competition  # noqa: PLC0415

    found = ended_tones(data)
    draw_competition(str(data.attrs["title"]), {"runs": found}, _picture(path))
    return {
        "confidence": 0.95,
        "tones": [t.as_data() for t in found],
        "picture": str(path),
    }


def _table(found: dict[str, Any]) -> Table:
    """Return what is printed: indices and tones as they are, of a map its range and border."""
    if "indices" in found:
        table = Table(title=f"Sobol indices of {found['quantity']}, 95 % intervals", title_justify="left")
        for heading in ("factor", "first order", "total"):
            table.add_column(heading, justify="left" if heading == "factor" else "right")
        for i in found["indices"]:
            first, total = (f"{i[k]:.3f} ({i[f'{k}_low']:.3f} to {i[f'{k}_high']:.3f})" for k in ("first", "total"))
            table.add_row(i["factor"], first, total)
        return table
    if "tones" in found:
        table = Table("tone", "runs", "share", "95 % confidence", title="tones", title_justify="left")
        for t in found["tones"]:
            table.add_row(
                t["words"], f"{t['count']} of {t['of']}", f"{t['share']:.0%}", f"{t['low']:.0%} to {t['high']:.0%}"
            )
        return table
    values = [v for row in found["value"] for v in row if v is not None]
    table = Table(title=f"{found['colour']} [{found['unit']}]", title_justify="left")
    for heading in ("cells", "runs", "least", "largest", "above zero"):
        table.add_column(heading, justify="right")
    above = f"{sum(v > 0 for v in values)} of {len(values)}"
    runs = sum(sum(row) for row in found["runs"])
    table.add_row(str(len(values)), str(runs), f"{min(values, default=0):.4g}", f"{max(values, default=0):.4g}", above)
    return table
