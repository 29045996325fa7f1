"""The page that sets the paper next to this software: items in, `paper.md` and its pictures out.

The page has two parts. `paper_stability.py` makes the items of tables, models and frequency domain; the time domain
has a module of its own. Writing one part leaves the other as it stands on the page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

Value = float | str | None
Row = tuple[str, str, Value, Value, Value]
"""Quantity, unit, the paper's value (None: it has none), ours, difference."""

PAGE = "paper.md"
PICTURES = "paper"
PARTS = {"stability": "Tables, models and frequency domain", "time": "Time domain"}

_TITLE = "The paper and this software, number by number"
_INTRODUCTION = """\
B. Ding, G. Squicciarini, D. J. Thompson, *Effects of rail dynamics and friction characteristics on curve squeal*,
J. Phys.: Conf. Ser. 744 (2016) 012146. `make paper` writes this page; nothing on it is typed by hand. Differences are
ours minus the paper's; an empty cell means that the paper gives no number. "As printed" are the cases with the numbers
of Tables 1 and 3, `case1` to `case4`; "inferred" are those with what Table 4 alone tells, `inferred1` to `inferred4`
(docs/stability.md). Differences are those of the cases as printed."""
_HEAD = "| quantity | unit | paper | here | difference |\n| --- | --- | --- | --- | --- |"
_THREE = "| quantity | unit | paper | as printed | difference | inferred |\n| --- | --- | --- | --- | --- | --- |"


@dataclass(frozen=True)
class Item:
    """One table, figure or claim of the paper next to ours.

    Attributes
    ----------
    label : what the paper calls it, such as "Table 4"
    title : what it shows
    rows : the numbers
    sentence : what the comparison says, with the reason of every miss
    figures : pictures that were written
    inferred : what the inferred cases have, by quantity; empty where they are not compared
    """

    label: str
    title: str
    rows: tuple[Row, ...] = ()
    sentence: str = ""
    figures: tuple[Path, ...] = ()
    inferred: Mapping[str, Value] = field(default_factory=dict)

    def beside(self, inferred: Item, note: str = "", figures: tuple[Path, ...] = ()) -> Item:
        """Return the item with a column for the inferred cases, whose item is given; a sentence and figures of both."""
        values = {row[0]: row[3] for row in inferred.rows}
        sentence = f"{self.sentence} {note}".strip()
        return replace(self, sentence=sentence, figures=(*self.figures, *figures), inferred=values)


def relative(paper: float, ours: float) -> str:
    """Return the difference of two numbers in per cent of the first.

    >>> relative(2.0, 2.1)
    '+5.0 %'
    """
    return f"{100 * (ours / paper - 1):+.1f} %"


def write_page(parts: dict[str, Sequence[Item]], folder: Path) -> Path:
    """Write the page, replacing the parts that are given; return its path.

    Parameters
    ----------
    parts : items by name of the part, keys of `PARTS`
    folder : where the page goes; pictures are linked relative to it
    """
    page = folder / PAGE
    text = page.read_text(encoding="utf-8") if page.is_file() else ""
    bodies = {name: _kept(text, name) for name in PARTS}
    bodies |= {name: _part(items, folder) for name, items in parts.items()}
    sections = [
        f"{_mark(name)}\n## {title}\n\n{bodies[name]}\n{_mark(name, end=True)}"
        for name, title in PARTS.items()
        if bodies[name]
    ]
    folder.mkdir(parents=True, exist_ok=True)
    page.write_text("\n\n".join([f"# {_TITLE}", _INTRODUCTION, *sections]) + "\n", encoding="utf-8", newline="\n")
    return page


def _mark(part: str, end: bool = False) -> str:
    return f"<!-- {'end of ' if end else ''}{part} -->"


def _kept(text: str, part: str) -> str:
    """Return what a page says in a part, without its heading; empty if it has no such part."""
    _, begin, rest = text.partition(f"{_mark(part)}\n")
    body, end, _ = rest.partition(f"\n{_mark(part, end=True)}")
    return body.partition("\n\n")[2] if begin and end else ""


def _part(items: Sequence[Item], folder: Path) -> str:
    return "\n\n".join(_item(item, folder) for item in items)


def _item(item: Item, folder: Path) -> str:
    """Return an item as Markdown."""
    blocks = [f"### {item.label}: {item.title}"]
    if item.sentence:
        blocks.append(item.sentence)
    if item.rows:
        blocks.append("\n".join(_table(item)))
    blocks += [f"![{item.label}]({figure.relative_to(folder).as_posix()})" for figure in item.figures]
    return "\n\n".join(blocks)


def _table(item: Item) -> list[str]:
    """Return the lines of the numbers; what the inferred cases alone have comes last."""
    if not item.inferred:
        return [_HEAD, *(_row(row) for row in item.rows)]
    known = {row[0] for row in item.rows}
    rows = [_row((*row, item.inferred.get(row[0]))) for row in item.rows]
    rows += [_row((name, None, None, None, None, v)) for name, v in item.inferred.items() if name not in known]
    return [_THREE, *rows]


def _row(row: Sequence[Value]) -> str:
    return "| " + " | ".join(_text(value) for value in row) + " |"


def _text(value: Value) -> str:
    """Return a value in four significant digits; a text as it is.

    >>> _text(1977.63), _text(0.30), _text(60e3), _text(2.1e9), _text(None)
    ('1978', '0.3', '60000', '2.1e+09', '')
    """
    if value is None:
        return ""
    if isinstance(value, str):
        return value.replace("|", "\\|")
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.4g}"
