/** The traces of a resonance map: values, contour lines, classes of points, and the best designs. */
/** @import { Catalogue, Figure, Layout, MapAnswer, Row, Trace } from "./types.js" */

import { colour, NARROW, thisPoint } from "./figure.js";
import { extentOf, isLogarithmic, isWide, short } from "./numbers.js";
import { axisTitle, CLASS_LOOKS } from "./vocabulary.js";

/** Largest number of symbols of one class on a map; more symbols would hide the values. */
const MOST_SYMBOLS = 900;
const LOCKED = 1;
/** Phrase after the name of a response class on a map of extrema. @type {Record<string, string>} */
const WHERE = { max: " where it is largest", min: " where it is smallest" };
const FAILED_FROM = 2;
/** Largest number of values for which every value is written along the axis. */
const FEW = 8;
/** Smallest number of points along each axis for contour lines; fewer points do not determine lines. */
const CONTOUR_POINTS = 6;
const CONTOUR_LINES = 12;
/** Relative difference below which values are equal up to rounding. */
const ROUNDING = 1e-9;

/**
 * @typedef {Pick<Catalogue, "variables" | "response_class">} Words
 * @typedef {{contours: boolean, classes: boolean}} Overlays
 * @typedef {{x: number, y: number, text: string}} Mark
 * @typedef {{best: (Mark & {acts: boolean, name?: string}) | null, other: (Mark & {acts: boolean}) | null,
 *   pareto: Mark[], point: {x: number, y: number} | null}} Marks If the recommended design has impacts,
 *   `other` is the best design without impacts; otherwise `other` is the best design with impacts.
 */

/**
 * The traces of a map.
 *
 * @param {MapAnswer} map the service's answer
 * @param {Overlays} overlays
 * @param {Marks} marks
 * @param {Words} words
 * @param {(number | null)[][]} [beside] values of another map that share the colour scale
 * @returns {Trace[]}
 */
export function mapTraces(map, overlays, marks, words, beside) {
  const coded = words.variables.find((v) => v.name === map.metric)?.coded ?? false;
  const { coloured, bar } = coded ? codes(map) : scale(map, beside);
  const z = coloured(map.values);
  const common = { x: map.x, y: map.y, z, zsmooth: false, colorscale: "Cividis" };
  /** @type {Trace[]} */
  const traces = [
    {
      ...common,
      type: "heatmap",
      ...bar,
      customdata: map.values,
      hoverongaps: false,
      hovertemplate: hover(map, coded),
      name: "",
    },
  ];
  const fine = map.x.length >= CONTOUR_POINTS && map.y.length >= CONTOUR_POINTS;
  const levels = overlays.contours && fine && !coded && contourLevels(z);
  if (levels) {
    traces.push({
      ...common,
      type: "contour",
      showscale: false,
      hoverinfo: "skip",
      autocontour: false,
      contours: { ...levels, coloring: "none", showlabels: false },
      line: { color: "rgba(255,255,255,.7)", width: 1 },
      showlegend: false,
    });
  }
  const kinds = codesOf(map, "response_class");
  if (kinds && overlays.classes) traces.push(...classSymbols(map, kinds, words));
  else if (kinds)
    traces.push(
      ...where(map, kinds, (kind) => kind === LOCKED, `locked to the base${WHERE[map.reduce ?? ""] ?? ""}`, {
        symbol: "circle",
        size: 4,
        color: "white",
        line: { width: 1, color: "#444" },
      }),
    );
  const status = codesOf(map, "status");
  traces.push(
    ...where(map, status, (code) => code >= FAILED_FROM, "failed", {
      symbol: "x-thin",
      size: 8,
      line: { width: 2, color: colour("fault") },
    }),
  );
  traces.push(...markers(marks));
  return traces;
}

/**
 * At most `CONTOUR_LINES` levels for contour lines, with round values. If the values are equal up to
 * rounding, for example because all points are locked, there are no levels. The plotting library would choose
 * levels of its own, find no line to draw, and fail.
 *
 * @param {(number | null)[][]} z
 */
function contourLevels(z) {
  const [low, high] = extentOf(z);
  const span = high - low;
  if (!(span > ROUNDING * Math.max(Math.abs(low), Math.abs(high)))) return null;
  const power = 10 ** Math.floor(Math.log10(span / CONTOUR_LINES));
  const size =
    power * /** @type {number} */ ([1, 2, 5, 10, 20].find((digit) => digit * power * CONTOUR_LINES >= span));
  const [start, end] = [size * (Math.floor(low / size) + 1), size * (Math.ceil(high / size) - 1)];
  return start <= end ? { start, end, size } : null;
}

/**
 * The response class or the status of every point of a map. The map may show another variable.
 *
 * @param {MapAnswer} map
 * @param {"response_class" | "status"} name
 */
function codesOf(map, name) {
  return map.metric === name ? /** @type {number[][]} */ (map.values) : map[name];
}

/**
 * The values that determine the colours, and the colour bar.
 *
 * @param {MapAnswer} map
 * @param {(number | null)[][]} [beside]
 */
function scale(map, beside) {
  const extent = extentOf([...map.values, ...(beside ?? [])]);
  const title = { text: map.long_name, side: NARROW.matches ? "top" : "right" };
  const ends = (/** @type {number[]} */ [zmin, zmax]) => (beside && zmin < zmax ? { zmin, zmax } : {});
  if (!isWide(extent))
    return {
      coloured: (/** @type {Row[]} */ rows) => rows,
      bar: { ...ends(extent), colorbar: { title, ...barLook() } },
    };
  const coloured = (/** @type {Row[]} */ rows) =>
    rows.map((row) => row.map((value) => (value !== null && value > 0 ? Math.log10(value) : null)));
  const ticks = [];
  for (let power = Math.floor(Math.log10(extent[0])); power <= Math.log10(extent[1]); power += 1) {
    for (const digit of [1, 2, 5]) {
      const tick = digit * 10 ** power;
      if (tick >= extent[0] && tick <= extent[1]) ticks.push(tick);
    }
  }
  return {
    coloured,
    bar: {
      ...ends(extent.map(Math.log10)),
      colorbar: {
        title,
        ...barLook(),
        tickvals: ticks.map(Math.log10),
        ticktext: ticks.map((tick) => short(tick, 3)),
      },
    },
  };
}

/** The position of the colour bar: beside the map, or below the map on a phone. */
function barLook() {
  const common = { thickness: 14, outlinewidth: 0 };
  return NARROW.matches ? { ...common, orientation: "h", y: -0.22, yanchor: "top", x: 0.5 } : common;
}

/** The colours and names of a variable with codes, and the colour bar. @param {MapAnswer} map */
function codes(map) {
  const meanings = map.meanings[map.metric];
  const known = Object.keys(meanings)
    .map(Number)
    .sort((a, b) => a - b);
  const edge = known.length;
  const colours = known.map((code, i) =>
    map.metric === "response_class"
      ? CLASS_LOOKS[String(code)].colour
      : ["#888888", "#009e73", "#f0e442", "#d55e00"][Math.min(i, 3)],
  );
  const colorscale = colours.flatMap((shade, i) => [
    [i / edge, shade],
    [(i + 1) / edge, shade],
  ]);
  const names = known.map((code) => meanings[code].replaceAll("_", " "));
  return {
    coloured: (/** @type {Row[]} */ rows) =>
      rows.map((row) => row.map((code) => (code === null ? null : known.indexOf(code)))),
    bar: {
      colorscale,
      zmin: -0.5,
      zmax: edge - 0.5,
      colorbar: { ...barLook(), tickvals: known.map((_, i) => i), ticktext: names },
    },
  };
}

/** @param {MapAnswer} map @param {boolean} coded */
function hover(map, coded) {
  const place =
    `${map.x_title ?? axisTitle(map.x_dimension)} = %{x}<br>${map.y_title ?? axisTitle(map.y_dimension)} ` +
    "= %{y}<br>";
  return coded ? place + "<extra></extra>" : `${place}${map.long_name} = %{customdata:.5~g}<extra></extra>`;
}

/**
 * Symbols at the points that meet a condition. If there are too many such points, some are left out.
 *
 * @param {MapAnswer} map
 * @param {number[][] | undefined} codes
 * @param {(code: number) => boolean} holds
 * @param {string} name
 * @param {unknown} marker
 */
function where(map, codes, holds, name, marker) {
  const found = /** @type {[number, number][]} */ ([]);
  codes?.forEach((row, j) => row.forEach((code, i) => holds(code) && found.push([map.x[i], map.y[j]])));
  if (found.length === 0) return [];
  const kept = thinned(found);
  return [
    {
      type: "scatter",
      mode: "markers",
      x: kept.map(([x]) => x),
      y: kept.map(([, y]) => y),
      marker,
      name,
      hoverinfo: "skip",
      showlegend: true,
    },
  ];
}

/** @template T @param {T[]} found @returns {T[]} */
function thinned(found) {
  const step = Math.ceil(found.length / MOST_SYMBOLS);
  return found.filter((_, i) => i % step === 0);
}

/**
 * Markers of every class, each with its own shape.
 *
 * @param {MapAnswer} map
 * @param {number[][]} kinds
 * @param {Words} words
 */
function classSymbols(map, kinds, words) {
  return Object.entries(words.response_class).flatMap(([code, { name }]) =>
    Number(code) < 0
      ? []
      : where(map, kinds, (kind) => kind === Number(code), name, {
          symbol: CLASS_LOOKS[code].shape,
          size: 9,
          color: CLASS_LOOKS[code].colour,
          line: { width: 1, color: "white" },
        }),
  );
}

/** @param {Marks} marks */
function markers({ best, other, pareto, point }) {
  const traces = [];
  /** @param {Mark[]} list @param {string} name @param {unknown} marker */
  const add = (list, name, marker) =>
    traces.push({
      type: "scatter",
      mode: "markers",
      x: list.map((m) => m.x),
      y: list.map((m) => m.y),
      text: list.map((m) => m.text),
      name,
      marker,
      hovertemplate: "%{text}<extra></extra>",
      showlegend: true,
      cliponaxis: false,
    });
  if (pareto.length)
    add(pareto, "Pareto front", {
      symbol: "diamond",
      size: 10,
      color: "white",
      line: { width: 2, color: "black" },
    });
  // white with a black edge, which is visible on light and on dark cells
  if (other)
    add([other], other.acts ? "best with impacts" : "best, no impact", {
      symbol: "star",
      size: 14,
      color: "white",
      line: { width: 1.5, color: "black" },
    });
  if (best)
    add([best], best.name ?? (best.acts ? "best with impacts" : "optimum"), {
      symbol: "star",
      size: 18,
      color: "#ff9f40",
      line: { width: 1.5, color: "black" },
    });
  if (point) {
    const { x, y } = point;
    traces.push({
      ...thisPoint(20, 3),
      x: [x],
      y: [y],
      name: "this point",
      showlegend: true,
      cliponaxis: false,
    });
  }
  return traces;
}

/** The layout of a map. @param {MapAnswer} map @returns {Layout} */
export function mapLayout(map) {
  return {
    xaxis: { title: map.x_title ?? axisTitle(map.x_dimension), ...span(map.x) },
    yaxis: { title: map.y_title ?? axisTitle(map.y_dimension), ...span(map.y) },
    plot_bgcolor: colour("empty"),
    margin: { l: 56, r: 8, t: 12, b: 48 },
    hovermode: "closest",
  };
}

/** Type and range of an axis, up to the outer edges of the cells. @param {number[]} values */
function span(values) {
  const log = isLogarithmic(values);
  const along = log ? values.map(Math.log10) : values;
  const half =
    along.length > 1
      ? [(along[1] - along[0]) / 2, (along[along.length - 1] - along[along.length - 2]) / 2]
      : [0.5, 0.5];
  // within a decade, the tick labels of the plotting library would overlap
  const few = { tickvals: values, ticktext: values.map((value) => short(value, 3)) };
  const ticks = !log ? {} : values.length <= FEW ? few : { dtick: "D2" };
  return {
    type: log ? "log" : "linear",
    range: [along[0] - half[0], along[along.length - 1] + half[1]],
    ...ticks,
  };
}

/**
 * Draw a map, or a curve if only one dimension varies.
 *
 * @param {Figure} chart
 * @param {MapAnswer} map
 * @param {() => Trace[]} traces of a map
 * @param {() => Trace[]} [lines] of a curve
 */
export async function drawMap(chart, map, traces, lines = () => lineTraces(map)) {
  if (map.y.length === 1) await chart.draw(lines, () => lineLayout(map));
  else await chart.draw(traces, () => mapLayout(map));
}

/** A curve in place of a map, if only one dimension varies. @param {MapAnswer} map */
function lineTraces(map) {
  return [
    {
      type: "scatter",
      mode: "lines+markers",
      x: map.x,
      y: map.values[0],
      line: { color: colour("curve-1") },
      name: map.long_name,
    },
  ];
}

/** @param {MapAnswer} map @returns {Layout} */
function lineLayout(map) {
  return {
    xaxis: { title: map.x_title ?? axisTitle(map.x_dimension) },
    yaxis: { title: map.long_name },
    showlegend: false,
  };
}
