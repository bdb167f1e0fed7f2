/** The traces of two maps on one colour scale, and of their difference. */
/** @import { MapAnswer, MapDifference, Row, Trace } from "./types.js" */

import { colour, CURVES, DASHES } from "./figure.js";
import { mapTraces } from "./map_figure.js";

/** Colour scale with white at 0; purple and orange can be distinguished with any colour vision. */
const DIVERGING = [
  [0, "#542788"],
  [0.25, "#998ec3"],
  [0.5, "#f7f7f7"],
  [0.75, "#f1a340"],
  [1, "#b35806"],
];
const NOTHING = { best: null, other: null, pareto: [] };

/** @typedef {{x: number, y: number} | null} Point */

/**
 * The traces of a map, on a colour scale that also covers the values of another map.
 *
 * @param {MapAnswer} map @param {{values: Row[]}} other @param {Point} point
 */
export function sharedTraces(map, other, point) {
  return mapTraces(
    map,
    { contours: true, classes: false },
    { ...NOTHING, point },
    { variables: [], response_class: {} },
    other.values,
  );
}

/**
 * The traces of the difference of two maps, which is white where the maps are equal.
 *
 * @param {MapDifference} map
 * @param {Point} point
 * @returns {Trace[]}
 */
export function differenceTraces(map, point) {
  const largest = Math.max(...map.difference.flat().map((value) => Math.abs(value ?? 0))) || 1;
  const traces = mapTraces(
    {
      ...map,
      values: map.difference,
      status: undefined,
      response_class: undefined,
      long_name: `difference, ${map.long_name}`,
    },
    { contours: false, classes: false },
    { ...NOTHING, point },
    { variables: [], response_class: {} },
  );
  Object.assign(traces[0], { z: map.difference, colorscale: DIVERGING, zmin: -largest, zmax: largest });
  return traces;
}

/**
 * The curves of both studies in one figure, if only one dimension varies.
 *
 * @param {MapDifference} map
 * @param {string[]} names
 * @returns {Trace[]}
 */
export function sideTraces(map, names) {
  const rows = [map.values[0], map.other[0]];
  return names.map((name, i) => ({
    type: "scatter",
    mode: "lines+markers",
    x: map.x,
    y: rows[i],
    name,
    line: { color: CURVES()[i], dash: DASHES[i] },
    marker: { size: 5, color: i ? undefined : colour("curve-1") },
  }));
}
