/**
 * Shows faults of a form below the fields that they name, with the label and the unit of each field.
 *
 * @typedef {{label?: string, unit?: string, scale?: string}} Looks label and unit of a field, and the factor
 *   from SI to this unit
 */
/** @import { Child, Fault } from "./types.js" */

import { sentences } from "./api.js";
import { capital, el, fill, prose } from "./dom.js";
import { short } from "./numbers.js";

/** Pattern of a number as the service writes numbers, but not inside a word. */
const NUMBER = /(?<![\w.,])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.,]*\w)/g;
/** Pattern of the keys `start`, `stop` and `num` of a range, except inside a path. */
const KEY = /(?<![\w.`])`?(start|stop|num)`?(?![\w`]|\.\w)/g;
const TITLES = { start: "“from”", stop: "“to”", num: "“values”" };
/** Pattern of texts about a count, in which numbers have no unit. */
const COUNTED = /list|values|points/;

/**
 * A field with its title, and a place for its faults.
 *
 * @param {string} path in the document
 * @param {string} title
 * @param {Child | Child[]} inputs one input, labelled by the title, or several inputs with their own labels
 * @param {{label?: string, unit?: string, scale?: number, wide?: boolean}} [looks] looks of the typed value
 */
export function field(path, title, inputs, { label, unit, scale = 1, wide = false } = {}) {
  return el(
    Array.isArray(inputs) ? "div" : "label",
    {
      class: wide ? "field wide" : "field",
      "data-field": path,
      "data-label": label,
      ...(scale === 1 ? {} : { "data-unit": unit, "data-scale": scale }),
    },
    el("span", {}, title),
    inputs,
    el("span", { class: "faults" }),
  );
}

/**
 * Show each fault at its field, and mark the field. Faults that belong to no field are shown in `elsewhere`.
 *
 * @param {Element} fields
 * @param {Fault[]} faults
 * @param {Element} elsewhere
 * @param {boolean} [all] whether missing values are marked too
 * @returns {{wrong: number, missing: number}} `missing` counts the faults of values that were not typed yet
 */
export function showFaults(fields, faults, elsewhere, all = true) {
  clearFaults(fields);
  fill(elsewhere);
  let missing = 0;
  for (const fault of faults) {
    const field = fieldOf(fields, fault.field);
    const inputs = [...(field?.querySelectorAll("input") ?? [])];
    const untouched =
      fault.found === "nothing" && inputs.length > 0 && inputs.every((each) => each.value === "");
    missing += Number(untouched);
    if (untouched && !all) continue;
    for (const input of inputs) input.setAttribute("aria-invalid", "true");
    const place = field?.querySelector(".faults:not(.upload)") ?? elsewhere;
    const told = el("p", {}, prose(worded(fault, /** @type {HTMLElement | null} */ (field)?.dataset ?? {})));
    if (![...place.children].some((each) => each.textContent === told.textContent)) place.append(told);
  }
  return { wrong: faults.length - missing, missing };
}

/** Remove faults and marks, except the fault of an uploaded file. @param {Element} fields */
function clearFaults(fields) {
  for (const place of fields.querySelectorAll(".faults:not(.upload)")) fill(place);
  for (const marked of fields.querySelectorAll("[aria-invalid]")) marked.removeAttribute("aria-invalid");
}

/**
 * The text of a fault, with the label and the unit of the field in the form.
 *
 * @param {Fault} fault
 * @param {Looks} looks label, unit and factor of the field
 */
export function worded(fault, { label, unit, scale }) {
  const factor = Number(scale ?? 1);
  if (factor === 1) {
    if (!label) return sentences(capital(fault.message), fault.advice);
    const message = fault.message.replace(`\`${fault.field}\``, label);
    return asTitled(sentences(capital(message), fault.advice));
  }
  const inUnit = (/** @type {string} */ text) =>
    COUNTED.test(text) ? text : text.replace(NUMBER, (value) => short(Number(value) * factor));
  const found = fault.found === "nothing" ? "" : `, not ${inUnit(fault.found)}`;
  const message = `${capital(label ?? fault.field)} [${unit}]: allowed is ${inUnit(fault.allowed)}${found}.`;
  // advice on units is left out, because the form shows another unit than the service uses
  return asTitled(sentences(message, fault.advice.startsWith("give it in") ? "" : fault.advice));
}

/** Replace the keys of a range by the titles of their fields. @param {string} text */
function asTitled(text) {
  return text.replace(KEY, (_, key) => /** @type {Record<string, string>} */ (TITLES)[key]);
}

/**
 * The element of a field. If no element has the complete path, parts at the end of the path are left out, one
 * after the other. If this does not help, only the first part is left out.
 *
 * @param {Element} fields
 * @param {string} name
 * @returns {Element | null}
 */
function fieldOf(fields, name) {
  const parts = name.replaceAll("[", ".").replaceAll("]", "").split(".");
  for (let length = parts.length; length > 0; length -= 1) {
    const found = fields.querySelector(`[data-field="${CSS.escape(parts.slice(0, length).join("."))}"]`);
    if (found) return found;
  }
  return fields.querySelector(`[data-field="${CSS.escape(parts.slice(1).join("."))}"]`);
}
