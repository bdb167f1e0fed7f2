/**
 * Whether quantities are shown as ratios or in units; the choice is remembered, and the same on every view.
 */
/** @import { MapAnswer, MapDifference, Row, Worded, Words } from "./types.js" */

import { el } from "./dom.js";
import { short } from "./numbers.js";
import { FREQUENCY } from "./selection.js";
import { axisTitle, called, lowered, symbol, titled } from "./vocabulary.js";
import { WORDS } from "./words.js";

const REMEMBERED = "damperlab.ratios";

/** The quantity in units for each ratio: symbol, name, unit, and the factor from SI. */
const QUANTITIES = WORDS.in_units;

/** Lengths in SI are shown in mm, like those that correspond to ratios. */
export const LENGTH_IN_SI = /_m$/;
export const MILLIMETRES = 1000;

/** Error relative to a value above which a shown digit of the value may be wrong. */
const SHOWN_DIGIT = 5e-6;

export class Shown {
  /** @param {Record<string, number>} inUnits factors from ratios of the study to SI */
  constructor(inUnits) {
    const known = Object.entries(QUANTITIES).filter(([name]) => name in inUnits);
    this.factors = Object.fromEntries(known.map(([name, [, , , scale]]) => [name, inUnits[name] * scale]));
    this.possible = Object.keys(this.factors).length > 0;
    this.inUnits = this.possible && localStorage.getItem(REMEMBERED) !== "yes";
  }

  /** Remember a new choice. @param {boolean} inUnits */
  remember(inUnits) {
    if (inUnits) localStorage.removeItem(REMEMBERED);
    else localStorage.setItem(REMEMBERED, "yes");
  }

  /** Whether one quantity is shown in units. @param {string} name */
  has(name) {
    return this.inUnits && name in this.factors;
  }

  /** The factor from a ratio, or from a quantity in SI, to the shown value. @param {string} name */
  factor(name) {
    if (LENGTH_IN_SI.test(name)) return MILLIMETRES;
    return this.has(name) ? this.factors[name] : 1;
  }

  /** The unit, with the space before it; empty for a ratio. @param {string} name */
  unit(name) {
    const unit = LENGTH_IN_SI.test(name) ? "mm" : this.has(name) ? QUANTITIES[name][2] : WORDS.units[name];
    return unit ? ` ${unit}` : "";
  }

  /** The unit in brackets. @param {string} name */
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
   * The error of a value in a table; a word if it is only rounding.
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
   * The name of a variable, with its unit or its reference.
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
   * The words of an answer, in units if the study is shown so.
   *
   * @param {Worded} answer
   * @returns {Required<Words>}
   */
  words(answer) {
    return { note: "", verdict: [], doubts: [], ...answer, ...(this.inUnits ? answer.in_units : {}) };
  }

  /** The name under which a quantity is requested in its shown units. @param {string} name */
  nameInSi(name) {
    return this.has(name) ? WORDS.names_in_si[name] : name;
  }

  /** A value in SI if it is shown in units, else the ratio. @param {string} name @param {number} value */
  inSi(name, value) {
    return this.has(name) ? (value * this.factors[name]) / QUANTITIES[name][3] : value;
  }

  /**
   * A difference of maps that was requested by `nameInSi`, in the shown units.
   *
   * @param {MapDifference} answer
   * @param {{x: string, y: string, metric: string}} names of its axes and its metric as ratios
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

  /** A map of the service in the shown units. @param {MapAnswer} answer */
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
 * Numbers times a factor; unknown values stay unknown.
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
 * A unit of the service for display, in brackets after a name; lengths are in mm. Empty for a ratio.
 *
 * @param {string} units
 */
export function inBrackets(units) {
  const printed =
    units === "m" ? "mm" : units.replace(/ s-(\d)/, (_, power) => (power === "1" ? "/s" : "/s²"));
  return units === "1" ? "" : ` [${printed}]`;
}

/**
 * The switch between ratios and units, if the study has both.
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
