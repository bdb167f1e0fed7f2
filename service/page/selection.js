/** The selected point of a study: one index along each of its dimensions. */
/** @import { Axes } from "./types.js" */

import { nearest } from "./numbers.js";

export const FREQUENCY = "frequency_ratio";
export const RECORD = "record";
export const AMPLITUDE = "base_amplitude_m";

/** @param {number[]} values texts for records @param {number | string} wanted */
function placeOf(values, wanted) {
  return typeof values[0] === "string"
    ? Math.max(0, values.indexOf(/** @type {number} */ (wanted)))
    : nearest(values, Number(wanted));
}

/** The selected point. If no frequency is selected, a map shows the worst case over the band. */
export class Selection extends EventTarget {
  /** @param {Axes} axes values along each dimension: numbers, or the ids of records for a suite */
  constructor(axes) {
    super();
    this.axes = axes;
    /** @type {Record<string, number>} */
    this.place = Object.fromEntries(Object.keys(axes).map((name) => [name, 0]));
    if (FREQUENCY in axes) this.place[FREQUENCY] = nearest(axes[FREQUENCY], 1);
    this.worst = FREQUENCY in axes && axes[FREQUENCY].length > 1;
    this.chosen = false;
  }

  /** Dimensions with more than one value. */
  get varied() {
    return Object.keys(this.axes).filter((name) => this.axes[name].length > 1);
  }

  /** Ids of the records of a suite; empty for other studies. @returns {string[]} */
  get records() {
    return /** @type {string[]} */ (/** @type {unknown} */ (this.axes[RECORD] ?? []));
  }

  /** @param {string} dimension */
  value(dimension) {
    return this.axes[dimension][this.place[dimension]];
  }

  /**
   * The values of the point, as parameters of a request. Dimensions with a single value are left out.
   *
   * @param {string[]} [except]
   * @returns {Record<string, number>}
   */
  at(except = []) {
    return Object.fromEntries(
      this.varied.filter((name) => !except.includes(name)).map((name) => [name, this.value(name)]),
    );
  }

  /**
   * Choose indices, and notify listeners of `chosen`.
   *
   * @param {Record<string, number>} places index by dimension
   */
  choose(places) {
    for (const [name, place] of Object.entries(places)) {
      this.place[name] = Math.min(this.axes[name].length - 1, Math.max(0, place));
    }
    this.chosen = true;
    this.dispatchEvent(new Event("chosen"));
  }

  /** Choose the grid point nearest to given values. @param {Record<string, number | string>} values */
  chooseValues(values) {
    const known = Object.entries(values).filter(([name]) => name in this.axes);
    this.choose(Object.fromEntries(known.map(([name, value]) => [name, placeOf(this.axes[name], value)])));
  }

  /** Choose the point of a design. The frequency is unchanged. @param {Record<string, number>} design */
  chooseDesign(design) {
    const named = this.varied.filter((name) => name !== FREQUENCY);
    this.chooseValues(Object.fromEntries(named.map((name) => [name, design[name]])));
  }

  /** Select a design, unless the user has chosen a point. @param {Record<string, number>} design */
  rest(design) {
    const elsewhere = this.varied.filter((name) => name !== FREQUENCY && this.value(name) !== design[name]);
    if (this.chosen || elsewhere.length === 0) return;
    for (const name of elsewhere) this.place[name] = placeOf(this.axes[name], design[name]);
    this.dispatchEvent(new Event("chosen"));
  }

  /** Set whether the worst case over the frequencies is shown. @param {boolean} worst */
  leaveFrequency(worst) {
    this.worst = worst;
    this.chosen = true;
    this.dispatchEvent(new Event("chosen"));
  }
}
