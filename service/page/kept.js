/** What a view shows, kept in its address: a link leads to the same view, and Back goes back one step. */

import { nearest } from "./numbers.js";

/** Changes that follow each other faster than this, as those of a slider do, are one step. */
const ONE_STEP_MILLISECONDS = 1000;

export class Kept {
  /** @param {string} path the address without its parameters @param {URLSearchParams} query */
  constructor(path, query) {
    this.path = path;
    /** @type {Record<string, string>} */
    this.values = Object.fromEntries(query);
    this.last = 0;
  }

  /**
   * What was kept under a name where it is one of those that are possible, else what is usual.
   *
   * @template {string} T
   * @param {string} name @param {readonly string[]} possible @param {T} usual
   * @returns {T | string}
   */
  one(name, possible, usual) {
    return possible.includes(this.values[name]) ? this.values[name] : usual;
  }

  /**
   * A number that was kept, between two limits.
   *
   * @param {string} name
   * @param {number} low
   * @param {number} high
   * @param {number} usual
   */
  number(name, low, high, usual) {
    const value = Number(this.values[name] || NaN);
    return value >= low && value <= high ? value : usual;
  }

  /** Whether something is on. @param {string} name @param {boolean} usual */
  on(name, usual) {
    return this.one(name, ["yes", "no"], usual ? "yes" : "no") === "yes";
  }

  /**
   * Keep what is shown now; what is as usual is left out.
   *
   * @param {Record<string, string | number | boolean | null | undefined>} values null, undefined and "" are
   *   as usual
   */
  keep(values) {
    const before = this.href;
    for (const [name, value] of Object.entries(values)) {
      if (value === null || value === undefined || value === "") delete this.values[name];
      else this.values[name] = typeof value === "boolean" ? (value ? "yes" : "no") : String(value);
    }
    if (this.href === before) return;
    const now = performance.now();
    if (now - this.last > ONE_STEP_MILLISECONDS) history.pushState(null, "", this.href);
    else history.replaceState(null, "", this.href);
    this.last = now;
  }

  /** The address with all that is kept. */
  get href() {
    return this.at(this.path);
  }

  /** Another view with all that is kept here. @param {string} path */
  at(path) {
    const query = new URLSearchParams(this.values).toString();
    return query ? `${path}?${query}` : path;
  }
}

/**
 * A value of an axis in the fewest digits that tell it from its neighbours.
 *
 * @param {(number | string)[]} values
 * @param {number} place
 */
export function plainly(values, place) {
  const value = values[place];
  if (typeof value !== "number") return String(value);
  for (let digits = 3; digits < 16; digits += 1) {
    const text = String(Number(value.toPrecision(digits)));
    if (
      nearest(values.map(Number), Number(text)) === place &&
      Math.abs(Number(text) - value) <= 1e-9 * Math.abs(value)
    )
      return text;
  }
  return String(value);
}
