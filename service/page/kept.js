/** Keeps the choices of a view in its address. A link leads to the same view, and Back undoes one step. */

import { nearest } from "./numbers.js";

/** Changes that follow each other within this time, as with a slider, are one step for Back. */
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
   * The kept value of a choice, or its default if the kept value is not allowed.
   *
   * @template {string} T
   * @param {string} name @param {readonly string[]} possible @param {T} usual
   * @returns {T | string}
   */
  one(name, possible, usual) {
    return possible.includes(this.values[name]) ? this.values[name] : usual;
  }

  /**
   * A kept number, or its default if the number is not within two limits.
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

  /** Whether a kept option is switched on. @param {string} name @param {boolean} usual */
  on(name, usual) {
    return this.one(name, ["yes", "no"], usual ? "yes" : "no") === "yes";
  }

  /**
   * Keep choices in the address.
   *
   * @param {Record<string, string | number | boolean | null | undefined>} values null, undefined or ""
   *   removes a choice from the address, so that its default applies
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

  /** The address with all kept choices. */
  get href() {
    return this.at(this.path);
  }

  /** The address of another view, with the choices of this view. @param {string} path */
  at(path) {
    const query = new URLSearchParams(this.values).toString();
    return query ? `${path}?${query}` : path;
  }
}

/**
 * A value of an axis, written with the fewest digits that distinguish the value from its neighbours.
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
