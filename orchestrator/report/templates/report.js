// Draws the figures of the page: when they come into view, in the colours of the reader's scheme, for mouse and keyboard.
"use strict";
(() => {
  const Draw = window.Plotly || window.moduleName;
  const figures = JSON.parse(document.getElementById("figures").textContent);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const drawn = new Set();

  const colours = () => (dark.matches && !window.matchMedia("print").matches
    ? { text: "#e8e8e8", grid: "#3a414a", wheel: "#7fb2e5", rail: "#f0a35e", sound: "#8fc9a0", limit: "#b0b0b0" }
    : { text: "#1b1b1b", grid: "#d5d8dc", wheel: "#0b5394", rail: "#c2570c", sound: "#2f7d4a", limit: "#555555" });

  const axis = (given, c) => ({ gridcolor: c.grid, zerolinecolor: c.grid, linecolor: c.grid, automargin: true,
    exponentformat: "power", ...given });

  function layout(given, c) {
    return { ...given, xaxis: axis(given.xaxis, c), yaxis: axis(given.yaxis, c),
      font: { color: c.text, size: 12 }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      margin: { l: 60, r: 12, t: 28, b: 46 }, legend: { orientation: "h", y: 1.12, x: 1, xanchor: "right" },
      hovermode: "closest", dragmode: "zoom" };
  }

  const trace = (given, c) => {
    const colour = c[given.role];
    return { ...given, line: { width: 1, ...given.line, color: colour }, marker: { ...given.marker, color: colour },
      error_y: given.error_y && { ...given.error_y, color: c.text } };
  };

  function draw(element) {
    const given = figures[element.id];
    const c = colours();
    drawn.add(element);
    return Draw.react(element, given.traces.map((t) => trace(t, c)), layout(structuredClone(given.layout), c),
      { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d"] });
  }

  // Zoom and move the horizontal axis about its middle, also where it is logarithmic or made of categories.
  function change(element, factor, shift) {
    const now = element._fullLayout.xaxis.range.map(Number);
    const half = (now[1] - now[0]) / 2;
    const middle = (now[0] + now[1]) / 2 + 2 * shift * half;
    Draw.relayout(element, { "xaxis.range": [middle - factor * half, middle + factor * half] });
  }

  const keys = {
    "+": (e) => change(e, 0.5, 0), "-": (e) => change(e, 2, 0),
    ArrowLeft: (e) => change(e, 1, -0.25), ArrowRight: (e) => change(e, 1, 0.25),
    0: (e) => Draw.relayout(e, { "xaxis.autorange": true }),
  };

  const elements = [...document.querySelectorAll(".canvas")];
  for (const element of elements) {
    element.addEventListener("keydown", (event) => {
      if (event.target === element && keys[event.key] && drawn.has(element)) {
        event.preventDefault();
        keys[event.key](element);
      }
    });
  }
  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries.filter((e) => e.isIntersecting)) {
      watcher.unobserve(entry.target);
      draw(entry.target);
    }
  }, { rootMargin: "300px" });
  elements.forEach((element) => watcher.observe(element));
  dark.addEventListener("change", () => drawn.forEach(draw));
  window.addEventListener("beforeprint", () => elements.forEach(draw));
  window.addEventListener("afterprint", () => drawn.forEach(draw));
})();
