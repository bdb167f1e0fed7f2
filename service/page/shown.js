/** Whether quantities of a study are shown as ratios or in units; remembered, and the same on every view. */
/** @import { MapAnswer, MapDifference, Row, Worded, Words } from "./types.js" */

import { el } from "./dom.js";
import { short } from "./numbers.js";
import { FREQUENCY } from "./selection.js";
import { axisTitle, called, lowered, symbol, titled } from "./vocabulary.js";
import { WORDS } from "./words.js";

const REMEMBERED = "damperlab.ratios";

/** What stands in units for a ratio: symbol, name, unit, and the unit over that of SI. */
const QUANTITIES = WORDS.in_units;

/** Dimensions and results in SI that are lengths are shown in mm, like those that stand for ratios. */
export const LENGTH_IN_SI = /_m$/;
export const MILLIMETRES = 1000;

/** The last digit that is shown of a value, over the value. */
const SHOWN_DIGIT = 5e-6;

export class Shown {
  /** @param {Record<string, number>} inUnits what ratios of the study are multiplied with to be in SI */
  constructor(inUnits) {
    const known = Object.entries(QUANTITIES).filter(([name]) => name in inUnits);
    this.factors = Object.fromEntries(known.map(([name, [, , , scale]]) => [name, inUnits[name] * scale]));
    this.possible = Object.keys(this.factors).length > 0;
    this.inUnits = this.possible && localStorage.getItem(REMEMBERED) !== "yes";
  }

  /** Remember another choice. @param {boolean} inUnits */
  remember(inUnits) {
    if (inUnits) localStorage.removeItem(REMEMBERED);
    else localStorage.setItem(REMEMBERED, "yes");
  }

  /** Whether one quantity is shown in units. @param {string} name */
  has(name) {
    return this.inUnits && name in this.factors;
  }

  /** What a ratio, or a quantity in SI, is multiplied with to be shown. @param {string} name */
  factor(name) {
    if (LENGTH_IN_SI.test(name)) return MILLIMETRES;
    return this.has(name) ? this.factors[name] : 1;
  }

  /** The unit, with the space before it; empty for a ratio. @param {string} name */
  unit(name) {
    const unit = LENGTH_IN_SI.test(name) ? "mm" : this.has(name) ? QUANTITIES[name][2] : WORDS.units[name];
    return unit ? ` ${unit}` : "";
  }

  /** The same in brackets. @param {string} name */
  inBrackets(name) {
    return this.unit(name).replace(" ", " [") + (this.unit(name) ? "]" : "");
  }

  /** Name and symbol of a dimension, with its unit. @param {string} name */
  title(name) {
    return this.has(name) ? QUANTITIES[name][1] + this.inBrackets(name) : titled(name);
  }

  /** The same without its unit. @param {string} name */
  called(name) {
    return this.has(name) ? QUANTITIES[name][1] : called(name);
  }

  /** Its symbol in plain text, with its unit. @param {string} name */
  short(name) {
    const symbol = this.has(name) ? QUANTITIES[name][0] : WORDS.symbols[name];
    return symbol.replace("_", "") + this.inBrackets(name);
  }

  /** The same as the plotting library sets it. @param {string} name */
  axis(name) {
    return this.has(name) ? this.title(name) : axisTitle(name);
  }

  /** What stands along an axis of frequencies. */
  frequency() {
    return this.has(FREQUENCY) ? this.title(FREQUENCY) : "frequency ratio r";
  }

  /** The symbol of a dimension as it is printed. @param {string} name @returns {HTMLElement} */
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
   * A value without its unit, and its error where a digit that is shown may be wrong.
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
   * The error of a value, in a table: a word where it is rounding.
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
   * What a variable is called, with its unit or what it is over.
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
   * The words of an answer: those in units where the study is shown so.
   *
   * @param {Worded} answer
   * @returns {Required<Words>}
   */
  words(answer) {
    return { note: "", verdict: [], doubts: [], ...answer, ...(this.inUnits ? answer.in_units : {}) };
  }

  /** The name by which a quantity is asked for in the units it is shown in. @param {string} name */
  nameInSi(name) {
    return this.has(name) ? WORDS.names_in_si[name] : name;
  }

  /** In SI where it is shown in units, a ratio elsewhere. @param {string} name @param {number} value */
  inSi(name, value) {
    return this.has(name) ? (value * this.factors[name]) / QUANTITIES[name][3] : value;
  }

  /**
   * A map less another one that was asked for by `nameInSi`, as it is shown.
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

  /** A map of the service as it is shown. @param {MapAnswer} answer */
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
 * Numbers times a factor; what is not known stays so.
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
 * A unit of the service as it is printed, in brackets after a name: lengths in mm; nothing for a ratio.
 *
 * @param {string} units
 */
export function inBrackets(units) {
  const printed =
    units === "m" ? "mm" : units.replace(/ s-(\d)/, (_, power) => (power === "1" ? "/s" : "/s²"));
  return units === "1" ? "" : ` [${printed}]`;
}

/**
 * The switch, where there is something to switch.
 *
 * @param {Shown} shown
 * @param {() => void} again shows the view anew
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
