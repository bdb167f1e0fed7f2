/** Names and meanings of dimensions and results. The catalogue of the service is requested once. */
/** @import { Catalogue, Definition, StudyRecord } from "./types.js" */

import { ask } from "./api.js";
import { el } from "./dom.js";
import { AMPLITUDE, RECORD } from "./selection.js";
import { WORDS } from "./words.js";

/** @type {Promise<Catalogue> | undefined} */
let asked;

/** @returns {Promise<Catalogue>} the catalogue of the service */
export function vocabulary() {
  asked ??= ask("catalog").catch((error) => {
    asked = undefined;
    throw error;
  });
  return asked;
}

const SYMBOLS = WORDS.symbols;

export const DIMENSIONS = WORDS.dimensions;

/** Dimensions that have no meaning without a particle. */
export const OF_PARTICLE = WORDS.of_particle;

/** The dimensions of a study that describe a design. @param {Definition} definition */
export function designDimensions(definition) {
  const without = definition.particle === false;
  const before = Object.entries(WORDS.before).filter(
    ([name, source]) => !without && (definition[name] ?? definition.physical?.[source] ?? null) !== null,
  );
  const always = DIMENSIONS.filter(
    (name) => name !== "frequency_ratio" && !(without && OF_PARTICLE.includes(name)),
  );
  return [...before.map(([name]) => name), ...always];
}

/** Readable names of dimensions, including those of suites. */
export const NAMES = WORDS.names;

/** Name and symbol of a dimension. @param {string} dimension */
export function called(dimension) {
  return SYMBOLS[dimension] ? `${NAMES[dimension]} ${SYMBOLS[dimension]}` : NAMES[dimension];
}

/** Name and symbol of a dimension, with its unit if it has one. @param {string} dimension */
export function titled(dimension) {
  const unit = WORDS.units[dimension];
  return called(dimension) + (unit ? ` [${unit}]` : "");
}

/** Name and symbol of a dimension in the markup of the plotting library. @param {string} dimension */
export function axisTitle(dimension) {
  return titled(dimension).replace(/_(\w)/, "<sub>$1</sub>");
}

/** The symbol of a dimension as an element. @param {string} dimension @returns {HTMLElement} */
export function symbol(dimension) {
  return lowered(SYMBOLS[dimension] ?? "");
}

/** A symbol with its subscript. @param {string} text @returns {HTMLElement} */
export function lowered(text) {
  const [letter, index] = text.split("_");
  return el("i", {}, letter, index && el("sub", {}, index));
}

/** The kind of study with the given dimensions. @param {string[]} dimensions */
export function kindOf(dimensions) {
  if (dimensions.includes(RECORD)) return "suite";
  return dimensions.includes(AMPLITUDE) ? "amplitudes" : "harmonic";
}

/** The dimensions of a kind of study, in the order of preference for maps. @param {string[]} dimensions */
export function orderOf(dimensions) {
  return { suite: WORDS.suite_axes, amplitudes: WORDS.amplitude_axes, harmonic: WORDS.axes }[
    kindOf(dimensions)
  ];
}

/** The criteria by which a tuned mass damper is tuned, for a picker. */
export const TUNINGS = Object.entries(WORDS.criteria);

/**
 * The colour and the shape of each response class (colours of Okabe and Ito 2008).
 *
 * @type {Record<string, {colour: string, shape: string}>}
 */
export const CLASS_LOOKS = {
  "-1": { colour: "#888888", shape: "line-ew-open" },
  0: { colour: "#999999", shape: "circle-open" },
  1: { colour: "#56b4e9", shape: "square" },
  2: { colour: "#0072b2", shape: "triangle-down" },
  3: { colour: "#009e73", shape: "circle" },
  4: { colour: "#f0e442", shape: "diamond" },
  5: { colour: "#e69f00", shape: "triangle-up" },
  6: { colour: "#cc79a7", shape: "cross" },
  7: { colour: "#d55e00", shape: "x" },
  8: { colour: "#444444", shape: "square-open" },
};

/**
 * Whether the service can probably subtract the maps of two studies. Only dimensions and numbers of values
 * are compared here; the service also compares the values. The particle's friction, or gravity, may be a
 * dimension of only one of the two studies: it is 0 in the other study.
 *
 * @param {Pick<StudyRecord, "dimensions" | "shape">} one
 * @param {Pick<StudyRecord, "dimensions" | "shape">} other
 * @param {string[]} along the axes of the map and the dimensions that are reduced
 */
export function isComparable(one, other, along) {
  const kind = (/** @type {typeof one} */ { dimensions }) =>
    dimensions.filter((name) => !(name in WORDS.before)).join();
  const size = (/** @type {typeof one} */ { dimensions, shape }, /** @type {string} */ name) =>
    shape[dimensions.indexOf(name)] ?? 1;
  return kind(one) === kind(other) && along.every((name) => size(one, name) === size(other, name));
}
