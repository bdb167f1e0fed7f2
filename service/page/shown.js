/** Shows quantities as ratios or in units, as the user has chosen for all views. */
/** @import { MapAnswer, MapDifference, Row, Worded, Words } from "./types.js" */

import { el } from "./dom.js";
import { short } from "./numbers.js";
import { FREQUENCY } from "./selection.js";
import { axisTitle, called, lowered, symbol, titled } from "./vocabulary.js";
import { WORDS } from "./words.js";

const REMEMBERED = "damperlab.ratios";

/** Symbol, name, unit, and factor from SI of the quantity that is shown in place of each ratio. */
const QUANTITIES = WORDS.in_units;

/** Pattern of the names of lengths in SI units, which are shown in mm. */
export const LENGTH_IN_SI = /_m$/;
export const MILLIMETRES = 1000;

/** Relative error above which a shown digit of a value may be wrong. */
const SHOWN_DIGIT = 5e-6;

export class Shown {
  /** @param {Record<string, number>} inUnits factors from ratios of the study to SI */
  constructor(inUnits) {
    const known = Object.entries(QUANTITIES).filter(([name]) => name in inUnits);
    this.factors = Object.fromEntries(known.map(([name, [, , , scale]]) => [name, inUnits[name] * scale]));
    this.possible = Object.keys(this.factors).length > 0;
    this.inUnits = this.possible && localStorage.getItem(REMEMBERED) !== "yes";
  }

  /** Store the choice in the browser. @param {boolean} inUnits */
  remember(inUnits) {
    if (inUnits) localStorage.removeItem(REMEMBERED);
    else localStorage.setItem(REMEMBERED, "yes");
  }

  /** Whether a quantity, given by its ratio, is shown in units. @param {string} name */
  has(name) {
    return this.inUnits && name in this.factors;
  }

  /** The factor from a ratio, or from a length in SI units, to the shown value. @param {string} name */
  factor(name) {
    if (LENGTH_IN_SI.test(name)) return MILLIMETRES;
    return this.has(name) ? this.factors[name] : 1;
  }

  /** The unit of a quantity, with a leading space; empty for a ratio. @param {string} name */
  unit(name) {
    const unit = LENGTH_IN_SI.test(name) ? "mm" : this.has(name) ? QUANTITIES[name][2] : WORDS.units[name];
    return unit ? ` ${unit}` : "";
  }

  /** The unit of a quantity in brackets; empty for a ratio. @param {string} name */
  inBrackets(name) {
    return this.unit(name).replace(" ", " [") + (this.unit(name) ? "]" : "");
  }

  /** Name and symbol of a dimension, with its unit. @param {string} name */
  title(name) {
    return this.has(name) ? QUANTITIES[name][1] + this.inBrackets(name) : titled(name);
  }

  /** Name and symbol of a dimension, without its unit. @param {string} name */
  called(name) {
    return this.has(name) ? QUANTITIES[name][1] : called(name);
  }

  /** Symbol of a dimension in plain text, with its unit. @param {string} name */
  short(name) {
    const symbol = this.has(name) ? QUANTITIES[name][0] : WORDS.symbols[name];
    return symbol.replace("_", "") + this.inBrackets(name);
  }

  /** Symbol of a dimension in the markup of the plotting library, with its unit. @param {string} name */
  axis(name) {
    return this.has(name) ? this.title(name) : axisTitle(name);
  }

  /** The title of an axis of frequencies. */
  frequency() {
    return this.has(FREQUENCY) ? this.title(FREQUENCY) : "frequency ratio r";
  }

  /** The symbol of a dimension as an element. @param {string} name @returns {HTMLElement} */
  symbol(name) {
    return this.has(name) ? lowered(QUANTITIES[name][0]) : symbol(name);
  }

  /**
   * A value with its unit.
   *
   * @param {string} name
   * @param {number | null | undefined} value
   * @param {number} [digits]
   */
  value(name, value, digits = 5) {
    return value === null || value === undefined
      ? "–"
      : short(value * this.factor(name), digits) + this.unit(name);
  }

  /**
   * A value without its unit, and its error if a shown digit may be wrong.
   *
   * @param {string} name
   * @param {number} value
   * @param {number | null | undefined} error
   */
  withError(name, value, error) {
    const by = this.factor(name);
    const doubt = error && error > SHOWN_DIGIT * Math.abs(value) ? ` ± ${short(error * by, 2)}` : "";
    return short(value * by) + doubt;
  }

  /**
   * The error of a value, for a table. An error as small as a rounding error is written as a word.
   *
   * @param {string} name
   * @param {number | null | undefined} value
   * @param {number | null | undefined} error
   */
  error(name, value, error) {
    if (error === null || error === undefined) return "–";
    if (value !== null && value !== undefined && error <= WORDS.rounding.share * Math.abs(value))
      return WORDS.rounding.word;
    return `± ${this.value(name, error, 2)}`;
  }

  /**
   * The name of a variable, with its unit or with the divisor of the ratio.
   *
   * @param {string} name
   * @param {string} otherwise
   */
  variable(name, otherwise) {
    if (this.has(name)) return this.title(name);
    return name in WORDS.over && !otherwise.includes("/")
      ? `${otherwise} over ${WORDS.over[name]}`
      : otherwise;
  }

  /**
   * The texts of an answer, in units if the page shows quantities in units.
   *
   * @param {Worded} answer
   * @returns {Required<Words>}
   */
  words(answer) {
    return { note: "", verdict: [], doubts: [], ...answer, ...(this.inUnits ? answer.in_units : {}) };
  }

  /**
   * The name of a quantity in a request: its name in SI units if the page shows units.
   * @param {string} name
   */
  nameInSi(name) {
    return this.has(name) ? WORDS.names_in_si[name] : name;
  }

  /** A ratio, converted to SI if it is shown in units. @param {string} name @param {number} value */
  inSi(name, value) {
    return this.has(name) ? (value * this.factors[name]) / QUANTITIES[name][3] : value;
  }

  /**
   * Convert a difference of maps, requested with names from `nameInSi`, into the shown units.
   *
   * @param {MapDifference} answer
   * @param {{x: string, y: string, metric: string}} names names of the axes and the metric as ratios
   */
  mapInSi(answer, { x, y, metric }) {
    const by = (/** @type {string} */ name) => (this.has(name) ? QUANTITIES[name][3] : this.factor(name));
    const plane = (/** @type {Row[]} */ rows) => rows.map((row) => times(row, by(metric)));
    const unit = this.has(metric) ? "" : inBrackets(answer.units);
    return {
      ...answer,
      x: times(answer.x, by(x)),
      y: times(answer.y, by(y)),
      values: plane(answer.values),
      other: plane(answer.other),
      difference: plane(answer.difference),
      long_name: this.variable(metric, answer.long_name) + unit,
      x_title: this.axis(x),
      y_title: this.axis(y),
    };
  }

  /** Convert a map of the service into the shown units. @param {MapAnswer} answer */
  map(answer) {
    const { metric, x_dimension: x, y_dimension: y } = answer;
    return {
      ...answer,
      x: times(answer.x, this.factor(x)),
      y: times(answer.y, this.factor(y)),
      values: answer.values.map((row) => times(row, this.factor(metric))),
      long_name: this.variable(metric, answer.long_name),
      x_title: this.axis(x),
      y_title: this.axis(y),
    };
  }
}

/**
 * Numbers multiplied by a factor. null stays null.
 *
 * @template {number | null} T
 * @param {T[]} values
 * @param {number} factor
 * @returns {T[]}
 */
export function times(values, factor) {
  return factor === 1
    ? values
    : values.map((value) => /** @type {T} */ (value === null ? null : value * factor));
}

/**
 * A unit of the service in brackets, for use after a name. Lengths are shown in mm. The text is empty for a
 * ratio.
 *
 * @param {string} units
 */
export function inBrackets(units) {
  const printed =
    units === "m" ? "mm" : units.replace(/ s-(\d)/, (_, power) => (power === "1" ? "/s" : "/s²"));
  return units === "1" ? "" : ` [${printed}]`;
}

/**
 * The switch between ratios and units; null if the study cannot be shown in units.
 *
 * @param {Shown} shown
 * @param {() => void} again redraws the view
 */
export function unitSwitch(shown, again) {
  if (!shown.possible) return null;
  const choose = el(
    "select",
    { "aria-label": "Quantities", onchange: () => (shown.remember(choose.value === "units"), again()) },
    el("option", { value: "units", selected: shown.inUnits }, "in units"),
    el("option", { value: "ratios", selected: !shown.inUnits }, "as ratios"),
  );
  return choose;
}
