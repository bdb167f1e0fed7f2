/**
 * Figures in the colours of the page, with downloads. The plotting library is loaded when the first figure is
 * drawn.
 *
 * @typedef {Record<string, unknown>} Trace a curve, a map or markers, as an object for the plotting library
 * @typedef {Record<string, unknown> & {dtick?: unknown, title?: string}} Axis
 * @typedef {Record<string, unknown> & {xaxis?: Axis, yaxis?: Axis, yaxis2?: Axis}} Layout
 * @typedef {{x: number, y: number, pointIndex: number, data: {name: string}}} Point of a trace
 * @typedef {HTMLDivElement & {data: Drawn[], layout: Titles, on: (event: string, told: (event: never) =>
 *   void) => void}} Plot
 * @typedef {{react: (plot: Plot, traces: Trace[], layout: Layout, settings: object) => Promise<Plot>,
 *   downloadImage: (plot: Plot, options: object) => Promise<string>}} Library
 * @typedef {{label: string, name: string, height?: number, keyboard?: string, python?: () => string,
 * clicked?: (point: Point) => void, zoomed?: (change: Record<string, unknown>) => void}} Options `label` is
 * for screen readers, `name` is the stem of the names of downloads. `keyboard` describes the keys of a figure
 * that can be focused. `python` returns equivalent Python code
 */
/** @import { Drawn, Titles } from "./types.js" */

import { button, details, el, fill, say } from "./dom.js";
import { tableOf } from "./figure_table.js";
import { short } from "./numbers.js";

/** Time after which the plotting library is loaded in browsers without `requestIdleCallback`. */
const UNTIL_IDLE_MILLISECONDS = 1000;

/** @type {Promise<Library> | undefined} */
let loading;

/** If an element has this id, the plotting library omits its style rules for geographic maps. */
const RULES_OF_MAPS = "9f215cf04c5486422605d13261cb87401f4e7763b6296af81e98efbc0130da53";

/** The figures on the page. They are drawn again when the colours change. @type {Set<Figure>} */
const shown = new Set();

window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  for (const drawn of shown) {
    if (drawn.element.isConnected) void drawn.again();
    else shown.delete(drawn);
  }
});

/** @returns {Promise<Library>} the plotting library; if loading fails, the next call tries again */
function plotly() {
  loading ??= new Promise((resolve, reject) => {
    const failed = () => {
      loading = undefined;
      reject(new Error("the plotting library could not be loaded"));
    };
    const loaded = () => {
      const { Plotly } = /** @type {typeof window & {Plotly?: Library}} */ (window);
      if (Plotly) resolve(Plotly);
      else failed();
    };
    const src = new URL("plotly.min.js", import.meta.url).href;
    const script = el("script", { src, onload: loaded, onerror: failed });
    document.head.append(el("meta", { id: RULES_OF_MAPS }), script);
  });
  return loading;
}

/**
 * Load the plotting library as soon as the page is idle. The first map then appears in half the time. If
 * loading fails, the first figure reports the failure.
 */
export function prepareFigures() {
  const load = () => void plotly().catch(() => undefined);
  if ("requestIdleCallback" in window) requestIdleCallback(load);
  else setTimeout(load, UNTIL_IDLE_MILLISECONDS);
}

/** A colour of the style sheet. @param {string} name */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Colours of curves, which can be distinguished with any colour vision. In a grey print the dashes help. */
export const CURVES = () => [
  colour("curve-1"),
  colour("curve-2"),
  colour("curve-3"),
  colour("curve-4"),
  colour("curve-5"),
];
export const DASHES = ["solid", "dash", "dot", "dashdot", "longdash"];

/** The marker of the selected point of a study. @param {number} size @param {number} [width] line width */
export function thisPoint(size, width = 2.5) {
  const marker = { symbol: "circle-open", size, color: "#ff3030", line: { width, color: "#ff3030" } };
  return { type: "scatter", mode: "markers", marker, hoverinfo: "skip" };
}

/** Whether the page is shown on a phone. */
export const NARROW = window.matchMedia("(max-width: 40rem)");

/** Ticks at 1, 2 and 5 in every decade of a logarithmic axis. The plotting library would label 20 as 2. */
const PLACES = Array.from({ length: 13 }, (_, i) => i - 6).flatMap((power) =>
  [1, 2, 5].map((first) => Number(`${first}e${power}`)),
);

/** The ticks of a logarithmic axis with three ticks per decade. @param {Axis} given */
function ticks(given) {
  return given.dtick === "D2"
    ? { dtick: null, tickvals: PLACES, ticktext: PLACES.map((one) => short(one)) }
    : {};
}

/** The layout that all figures share. @param {Layout} layout */
function styled(layout) {
  const axis = {
    gridcolor: colour("line"),
    linecolor: colour("quiet"),
    zerolinecolor: colour("line"),
    tickcolor: colour("quiet"),
    ticks: "outside",
    automargin: true,
    title: { standoff: 8 },
  };
  /** @type {Layout} */
  const merged = {
    paper_bgcolor: colour("paper"),
    plot_bgcolor: colour("paper"),
    font: { family: "system-ui, sans-serif", size: NARROW.matches ? 12 : 13, color: colour("ink") },
    margin: { l: 56, r: 12, t: 12, b: 48 },
    hoverlabel: { bgcolor: colour("paper"), font: { color: colour("ink") } },
    legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, bgcolor: "rgba(0,0,0,0)" },
    dragmode: window.matchMedia("(pointer: coarse)").matches ? false : "zoom",
    ...layout,
  };
  for (const name of Object.keys(layout)
    .filter((key) => /^[xy]axis\d*$/.test(key))
    .concat("xaxis", "yaxis")) {
    const given = /** @type {Axis} */ (layout[name] ?? {});
    merged[name] = { ...axis, ...given, ...ticks(given), title: { ...axis.title, text: given.title ?? "" } };
  }
  return merged;
}

/** A figure. The element is empty until the figure is drawn. */
export class Figure {
  /** Draws the figure again. */
  again = async () => {};
  wired = false;

  /** @param {Options} options */
  constructor(options) {
    this.options = options;
    const { label, height = 320, keyboard, python } = options;
    const looks = keyboard
      ? { tabindex: 0, role: "application", "aria-label": `${label}. ${keyboard}` }
      : { role: "img", "aria-label": label };
    this.plot = /** @type {Plot} */ (el("div", { class: "plot", "data-height": height, ...looks }));
    this.code = el("pre", { tabindex: 0, role: "region", "aria-label": `Python for: ${label}` });
    this.element = el(
      "figure",
      { class: "figure" },
      this.plot,
      el(
        "div",
        { class: "row end downloads" },
        ["png", "svg", "csv"].map((format) => this.download(format)),
      ),
      python && details("The same in Python", this.code),
    );
  }

  /** @param {string} format */
  download(format) {
    const says = `Download as ${format.toUpperCase()}: ${this.options.label}`;
    const onclick = () => (format === "csv" ? this.saveTable() : this.save(format));
    return button(format.toUpperCase(), onclick, { class: "small quiet", "aria-label": says });
  }

  /** @param {string} format */
  async save(format) {
    const library = await plotly();
    const { name } = this.options;
    const { width, height } = this.plot.getBoundingClientRect();
    const scale = format === "png" ? 2 : 1;
    await library.downloadImage(this.plot, { format, filename: name, width, height, scale });
    say(`${name}.${format} was saved.`);
  }

  saveTable() {
    const { name } = this.options;
    const table = tableOf(this.plot.data, this.plot.layout);
    const url = URL.createObjectURL(new Blob([table], { type: "text/csv" }));
    el("a", { href: url, download: `${name}.csv` }).click();
    URL.revokeObjectURL(url);
    say(`${name}.csv was saved.`);
  }

  /**
   * Draw the figure; both functions are called again when the colours of the page change.
   *
   * @param {() => Trace[]} traces
   * @param {() => Layout} layout
   */
  async draw(traces, layout) {
    const { height = 320, python } = this.options;
    this.again = async () => {
      const library = await plotly();
      const settings = { responsive: true, displayModeBar: false, doubleClick: "reset" };
      if (python) fill(this.code, python());
      if (!this.element.isConnected) return;
      await library.react(this.plot, traces(), styled({ height, ...layout() }), settings);
      this.wire();
    };
    shown.add(this);
    await this.again();
  }

  /** Attach the listeners to the plot, which must have been drawn before. */
  wire() {
    if (this.wired) return;
    this.wired = true;
    const { clicked, zoomed } = this.options;
    if (clicked)
      this.plot.on("plotly_click", (/** @type {{points: Point[]}} */ { points: [point] }) => clicked(point));
    if (zoomed) this.plot.on("plotly_relayout", zoomed);
  }
}
