/** Form fields of a specification: numbers, ranges and lists, each at a path in the document. */
/** @import { Child, Held, SpecifiedField } from "./types.js" */

import { capital, el } from "./dom.js";
import { field } from "./faults.js";
import { listBox } from "./lists.js";

/**
 * A group of fields with a title, and a place for faults.
 *
 * @param {string} title
 * @param {string} path
 * @param {Child[]} children
 */
export function group(title, path, children) {
  return el(
    "fieldset",
    { "data-field": path },
    el("legend", {}, title),
    el("div", { class: "pairs" }, children),
    el("div", { class: "faults" }),
  );
}

/**
 * A field for one number.
 *
 * @param {Held} held
 * @param {string} path
 * @param {SpecifiedField} each
 * @param {string} [title]
 */
export function number(held, path, each, title = titled(each)) {
  const value = held.get(path);
  const box = el("input", {
    type: "number",
    step: "any",
    value: shown(value, each),
    placeholder: each.usual_value ?? "",
    oninput: () => held.set(path, read(box.value, each)),
  });
  return field(path, title, box, each);
}

/**
 * Fields for a number or a range.
 *
 * @param {Held} held
 * @param {string} path
 * @param {SpecifiedField} each
 * @param {string} [title]
 */
export function span(held, path, each, title = titled(each)) {
  const value = held.get(path);
  const [low, high] =
    value !== null && typeof value === "object" ? [value.start, value.stop] : [value, undefined];
  const start = el("input", {
    type: "number",
    step: "any",
    value: shown(low, each),
    "aria-label": `${titled(each)}, from`,
    oninput: () => change(),
  });
  const stop = el("input", {
    type: "number",
    step: "any",
    value: shown(high, each),
    "aria-label": `${titled(each)}, to; empty for one value`,
    oninput: () => change(),
  });
  function change() {
    const [one, other] = [read(start.value, each), read(stop.value, each)];
    held.set(path, other === undefined ? one : { start: one, stop: other });
  }
  return field(path, title, [el("span", { class: "ends" }, start, "to", stop)], each);
}

/** The title of a field. @param {SpecifiedField} each */
export function titled(each) {
  return capital(each.label) + (each.unit ? ` [${each.unit}]` : "");
}

/** A number in the shown unit. @param {unknown} value @param {SpecifiedField} each @returns {unknown} */
export function shown(value, each) {
  return typeof value === "number" ? Number((value * each.scale).toPrecision(12)) : (value ?? "");
}

/**
 * The typed number, in the unit of the document. Any other text is returned unchanged; the service checks it.
 *
 * @param {string} typed
 * @param {SpecifiedField} each
 * @returns {number | string | undefined}
 */
export function read(typed, each) {
  if (typed.trim() === "") return undefined;
  const value = Number(typed);
  return Number.isNaN(value) ? typed : Number((value / each.scale).toPrecision(15));
}

/**
 * A text field for a list of numbers. If `entry` is given, it converts each part of the text into an entry.
 *
 * @param {Held} held
 * @param {string} path
 * @param {SpecifiedField} each
 * @param {{title?: string, value: string, between?: RegExp, entry?: (part: string) => unknown}} list
 */
export function numbers(held, path, each, { title = titled(each), value, between, entry }) {
  const one = entry ?? ((/** @type {string} */ part) => read(part, each));
  const put = (/** @type {string[]} */ parts) => held.set(path, parts.map(one));
  return field(path, title, listBox(value, put, { "aria-label": title }, between), each);
}
