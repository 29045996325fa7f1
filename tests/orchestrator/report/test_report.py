"""The report: what it says, and how it behaves in a browser without a network."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from command_line import curvesqueal
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from synthetic_results import generic, mode_number, vibrating

from orchestrator.errors import InputError
from orchestrator.report.page import write_report
from orchestrator.report.plots import envelope, plain
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario

TONE = 1102.0


@given(hnp.arrays(float, st.integers(1, 400), elements=st.floats(-1e6, 1e6)), st.integers(1, 50))
def test_decimation_hides_no_peak(signal: np.ndarray, pieces: int) -> None:
    """Smallest and largest value of a signal are always in its envelope, and the envelope adds no other extreme."""
    x, y = envelope(np.arange(float(signal.size)), signal, pieces)
    assert (y.min(), y.max()) == (signal.min(), signal.max())
    assert x.size == y.size <= max(2 * pieces, signal.size)


def test_numbers_keep_five_digits() -> None:
    assert plain([123456.789, -1.23456789e-7, 0.0, 5.0]) == [123460.0, -1.2346e-7, 0.0, 5.0]


def squealing(path: Path) -> Path:
    """Write results in which the wheel squeals at a known tone, with nothing known of its contact."""
    data = vibrating({"(3,0)": (TONE, 1.3)})
    shape = generic().modes.shape[mode_number("(3,0)")]
    motion = data[f"wheel.modal_velocity_{mode_number('(3,0)') + 1:03d}"].to_numpy()
    for k, d in enumerate(("lon", "lat", "ver", "spin")):
        data[f"wheel.v_{d}"] = xr.DataArray((shape[k] * motion).astype(np.float32), dims="time", attrs={"units": "m/s"})
        data[f"rail.v_{d}"] = xr.DataArray((0.1 * shape[k] * motion).astype(np.float32), dims="time")
    data.attrs.update(title="<case> & synthetic", algorithm="staggered")
    data.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")
    return path


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the page of a squealing run and of a run that is too short for anything."""
    folder = tmp_path_factory.mktemp("report")
    quiet = run_scenario(Scenario("case1", duration=0.01), folder, Report()).results
    return write_report([squealing(folder / "squeal.nc"), quiet], folder / "out")


def test_page_says_what_the_runs_do(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert f"Squeal at {TONE:.1f} Hz" in text
    assert "The vibration has reached a steady limit cycle." in text
    assert "No squeal: in the second half of 0.01 s" in text
    assert re.search(r"No sound: .*too short for lines 2 Hz apart; that needs 0\.5 s", text)
    assert "&lt;case&gt; &amp; synthetic" in text
    assert "makes no stable mode unstable" in text
    assert "hertz_stiffness" in text
    assert re.search(r"numba \d", text)
    assert page.stat().st_size < 2.5e6


def test_page_names_nothing_in_the_network(page: Path) -> None:
    """No element but the paper's own text refers to anything outside; the policy forbids it besides."""
    text = page.read_text(encoding="utf-8")
    own = re.sub(r"<script>.*?</script>", "", text, flags=re.S)
    assert not re.search(r"(src|href)=\"(?!#|data:)", own)
    assert "default-src 'none'" in text


def test_bad_input_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "text.nc").write_text("hello")
    vibrating({}).to_netcdf(tmp_path / "other.nc", engine="scipy", format="NETCDF3_64BIT")
    for name, message in (
        ("none.nc", "no such results file"),
        ("text.nc", "is not a results file"),
        ("other.nc", "holds no wheel.v_lat, so it is not a run of the wheel/rail system"),
    ):
        with pytest.raises(InputError, match=message):
            write_report([tmp_path / name], tmp_path)
    done = curvesqueal("report", str(tmp_path / "none.nc"))
    assert done.returncode == 1
    assert "no such results file" in done.stderr


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """Return a headless Chromium."""
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no Chromium on this machine")
    sync = pytest.importorskip("playwright.sync_api")
    with sync.sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=program, args=["--no-sandbox", "--autoplay-policy=no-user-gesture-required"]
        )
        yield browser
        browser.close()


class Visit:
    """A page in a browser, with everything it complained about and asked for."""

    def __init__(self, browser: Any, page: Path, **how: Any) -> None:
        self.context = browser.new_context(**{"viewport": {"width": 1200, "height": 900}, **how})
        self.tab = self.context.new_page()
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.tab.on("console", lambda m: self.complaints.append(m.text) if m.type in ("error", "warning") else None)
        self.tab.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.tab.on("request", lambda r: self.requests.append(r.url.partition(",")[0]))
        self.tab.goto(page.as_uri())

    def figure(self, key: str) -> Any:
        """Return a figure, brought into view and drawn."""
        self.tab.locator(f"#{key}").scroll_into_view_if_needed()
        self.tab.wait_for_selector(f"#{key} .main-svg", timeout=60_000)
        return self.tab.locator(f"#{key}")

    def wait(self, expression: str) -> None:
        """Wait until something is true in the page; its policy forbids Playwright's own way."""
        for _ in range(600):
            if self.tab.evaluate(expression):
                return
            self.tab.wait_for_timeout(50)
        pytest.fail(f"never true: {expression}")

    def range(self, key: str) -> list[float]:
        """Return the range of a figure's horizontal axis."""
        found: list[float] = self.tab.evaluate(f"document.getElementById('{key}')._fullLayout.xaxis.range")
        return found


def test_every_figure_is_drawn_without_complaint_or_request(chromium: Any, page: Path) -> None:
    visit = Visit(chromium, page)
    keys = visit.tab.eval_on_selector_all(".canvas", "all => all.map(e => e.id)")
    assert len(keys) == 1 + 6 + 8
    for key in keys:
        assert visit.figure(key).locator(".main-svg").count() > 0
    assert visit.complaints == []
    assert [r for r in visit.requests if not r.startswith(("file:", "data:", "blob:"))] == []
    visit.context.close()


def test_figures_respond_to_mouse_and_keyboard(chromium: Any, page: Path) -> None:
    visit = Visit(chromium, page)
    figure = visit.figure("run1-0")
    figure.scroll_into_view_if_needed()
    box = figure.bounding_box()
    middle = box["y"] + 0.55 * box["height"]
    visit.tab.mouse.move(box["x"] + 0.5 * box["width"], middle)
    visit.tab.wait_for_selector("#run1-0 .hoverlayer .hovertext", timeout=30_000)
    assert re.search(r"s: .*m/s", figure.locator(".hoverlayer").text_content())
    before = visit.range("run1-0")
    visit.tab.mouse.down()
    visit.tab.mouse.move(box["x"] + 0.7 * box["width"], middle, steps=5)
    visit.tab.mouse.up()
    zoomed = visit.range("run1-0")
    assert zoomed[1] - zoomed[0] < 0.5 * (before[1] - before[0])
    figure.focus()
    visit.tab.keyboard.press("0")
    visit.wait("document.getElementById('run1-0')._fullLayout.xaxis.range[1] > 1.9")
    visit.tab.keyboard.press("+")
    visit.wait("document.getElementById('run1-0')._fullLayout.xaxis.range[1] < 1.9")
    assert visit.complaints == []
    visit.context.close()


def test_audio_plays(chromium: Any, page: Path) -> None:
    visit = Visit(chromium, page)
    visit.wait("document.querySelector('audio').readyState >= 1")
    assert visit.tab.evaluate("document.querySelector('audio').duration") == pytest.approx(2.0, abs=0.1)
    assert visit.tab.evaluate("document.querySelector('audio').play().then(() => true)")
    visit.wait("document.querySelector('audio').currentTime > 0.05")
    assert visit.tab.locator("audio").count() == 1
    visit.context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_fits_a_phone_in_either_scheme(chromium: Any, page: Path, scheme: str) -> None:
    """Nothing is wider than the screen, and text and background differ as the scheme asks."""
    visit = Visit(chromium, page, viewport={"width": 390, "height": 844}, color_scheme=scheme)
    visit.figure("run1-0")
    assert visit.tab.evaluate("document.documentElement.scrollWidth") <= 390
    back = visit.tab.evaluate("getComputedStyle(document.body).backgroundColor")
    brightness = sum(map(int, re.findall(r"\d+", back)[:3]))
    assert (brightness > 600) == (scheme == "light")
    ink = visit.tab.evaluate("document.getElementById('run1-0')._fullLayout.font.color")
    assert (ink == "#e8e8e8") == (scheme == "dark")
    visit.context.close()


def test_screen_readers_and_keyboards_find_everything(chromium: Any, page: Path) -> None:
    """A language, one main heading, headings in order, every figure named and reachable, every table with headers."""
    visit = Visit(chromium, page)
    tab = visit.tab
    assert tab.locator("html[lang=en]").count() == 1
    levels = tab.eval_on_selector_all("h1, h2, h3", "all => all.map(e => Number(e.tagName[1]))")
    assert levels == [1, 2, 2, 2]
    names = tab.eval_on_selector_all(".canvas", "all => all.map(e => [e.tabIndex, e.getAttribute('aria-label')])")
    assert all(index == 0 and len(name) > 20 for index, name in names)
    assert tab.locator("table:not(:has(th))").count() == 0
    tab.keyboard.press("Tab")
    assert tab.evaluate("document.activeElement.className") == "skip"
    visit.context.close()


def test_report_command_prints_one_json_object(page: Path, tmp_path: Path) -> None:
    done = curvesqueal("report", str(page.parent.parent / "squeal.nc"), "--out", str(tmp_path), "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["runs"] == 1
    assert (tmp_path / "report.html").is_file()
