/** Shows the last accuracy report in the service's data folder: errors and run times of the solver. */
/** @import { Diagram, Extreme, View } from "./types.js" */

import { ask } from "./api.js";
import { el, fill, grid, heading, quiet } from "./dom.js";
import { CURVES, DASHES, Figure } from "./figure.js";
import { help } from "./help.js";
import { count, moment, short } from "./numbers.js";

/** Errors below this value are drawn at this value, because a logarithmic axis has no zero. */
const FLOOR = 1e-17;
const SHAPES = ["star", "circle", "square", "diamond", "triangle-up"];

/** @type {View} */
export async function accuracyView(root) {
  // The list is requested first: a browser would log the refusal of a missing report as an error.
  const { reports } = await ask("accuracy/reports");
  if (reports.length === 0) return fill(root, el("h1", {}, "Accuracy"), noReport());
  const report = await ask("accuracy");
  const charts = report.diagrams.map((diagram) => ({
    diagram,
    chart: chartOf(diagram),
  }));
  fill(
    root,
    heading("Accuracy", help("accuracy/", "accuracy and speed")),
    el(
      "p",
      {},
      `Measured ${moment(report.created)} with version ${report.version} on ` +
        `${report.machine?.cores ?? "?"} cores. `,
      report.passed
        ? "Every extreme case passed."
        : el("strong", {}, "Not every extreme case passed: see the table."),
    ),
    el("h2", {}, "Error against run time"),
    quiet(
      "Farther left is faster, farther down is more exact. The error is that of the state after some " +
      "cycles " +
        "from rest, against a reference computed with 40 digits. The event-driven solver has no step " +
        "size, so it is one point.",
    ),
    el(
      "div",
      { class: "grid" },
      charts.map(({ diagram, chart }) => el("section", {}, el("h3", {}, diagram.title), chart.element)),
    ),
    el("h2", {}, "Extreme cases"),
    table(report.stability),
  );
  queueMicrotask(async () => {
    for (const { diagram, chart } of charts) await chart.draw(() => traces(diagram), layout);
  });
}

function noReport() {
  return el(
    "div",
    { class: "box" },
    el("h2", {}, "No report yet"),
    el(
      "p",
      {},
      "A report measures the solver on this machine: its error against its run time, with the paper’s " +
        "method for comparison, and its results for extreme cases. It takes a few minutes:",
    ),
    el("pre", { tabindex: 0, role: "region", "aria-label": "Command" }, "damperlab check accuracy --quick"),
    quiet(
      "Run it with the data folder of this service (--data-dir, as for serve), then open this page again.",
    ),
  );
}

/** @param {Diagram} diagram */
function chartOf(diagram) {
  return new Figure({
    label: `Error against run time: ${diagram.title}`,
    name: `work-precision-${diagram.scene}`,
    height: 340,
  });
}

/** @param {Diagram} diagram */
function traces(diagram) {
  return diagram.curves.map((curve, i) => {
    const points = curve.points.filter((point) => point.error !== null);
    const order = curve.order === null ? "" : `, order ${short(curve.order, 2)}`;
    return {
      type: "scatter",
      mode: "lines+markers",
      name: curve.method + order,
      x: points.map((point) => point.microseconds),
      y: points.map((point) => Math.max(point.error ?? 0, FLOOR)),
      text: points.map((point) => (curve.setting ? `${short(point.setting)} ${curve.setting}` : "")),
      hovertemplate: "%{x:.3~g} µs, error %{y:.2e}<br>%{text}",
      line: { color: CURVES()[i % 5], dash: DASHES[i % 5] },
      marker: { symbol: SHAPES[i % 5], size: 9, color: CURVES()[i % 5] },
    };
  });
}

function layout() {
  return {
    xaxis: { type: "log", title: "run time per cycle [µs]", dtick: 1 },
    yaxis: { type: "log", title: "relative error", exponentformat: "power", dtick: 3 },
    legend: { orientation: "h", y: -0.25, yanchor: "top", x: 0, bgcolor: "rgba(0,0,0,0)" },
  };
}

/** @param {Extreme[]} rows */
function table(rows) {
  const columns = /** @type {[string, (row: Extreme) => string][]} */ ([
    ["Cycles", (row) => count(row.cycles)],
    ["Impacts", (row) => count(row.impacts)],
    ["Energy residual", (row) => short(row.energy_residual, 2)],
    ["µs per cycle", (row) => short(row.microseconds, 3)],
    ["Paper’s method", (row) => row.paper],
  ]);
  return grid(
    "Extreme cases",
    ["Case", "Result", ...columns.map(([title]) => title)],
    rows.map((row) => [
      row.name,
      row.passed ? "✓ passed" : `✕ ${row.status}`,
      ...columns.map(([, cell]) => cell(row)),
    ]),
  );
}
