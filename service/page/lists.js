/** Reads typed lists: values separated by commas, semicolons or spaces. */

import { el, fill, smallButton } from "./dom.js";

/** A single comma between two digits: a decimal comma, or two values. */
const EITHER = /(?<=^|\s)[+-]?\d+,\d+(?=\s|$)/;
/** Separators of numbers other than commas. */
const SPACES = /[;\s]+/;
/** The same for values with names, which contain spaces: `rubber 0.3`. */
export const SEMICOLON = /;/;

/**
 * The parts of a list. "0,2" stays one part, since its meaning is unclear; "1,2,3" and "0.2,0.5" are lists.
 *
 * @param {string} text
 * @param {RegExp} [between]
 */
export function parts(text, between = SPACES) {
  return text
    .split(/,(?=\s|$)/)
    .flatMap((part) => part.split(between))
    .map((part) => part.trim())
    .flatMap((part) => (EITHER.test(part) ? [part] : part.split(",")))
    .filter(Boolean);
}

/**
 * The question about an unclear list, and both readings; null if it is clear.
 *
 * @param {string} text
 * @param {RegExp} [between]
 * @returns {{question: string, decimal: string, list: string} | null}
 */
export function doubt(text, between = SPACES) {
  const found = parts(text, between);
  const [unclear] = found.flatMap((part) => EITHER.exec(part) ?? []);
  if (unclear === undefined) return null;
  const meant = (/** @type {string} */ comma) =>
    found.map((part) => part.replace(EITHER, (value) => value.replace(",", comma))).join(", ");
  return {
    question: `Is ${unclear} the number ${unclear.replace(",", ".")}, or ${unclear.replace(",", " and ")}?`,
    decimal: meant("."),
    list: meant(", "),
  };
}

/**
 * @param {string} value
 * @param {(parts: string[]) => void} onChange called with the typed parts
 * @param {Record<string, unknown>} [attributes] of the box
 * @param {RegExp} [between] as in `parts`
 * @returns {HTMLElement[]} the box, and the place for the question
 */
export function listBox(value, onChange, attributes = {}, between = undefined) {
  const box = el("input", { type: "text", ...attributes, value, oninput: () => typed(box.value) });
  const asks = el("span", { class: "asks", role: "status" });

  /** @param {string} text */
  function typed(text) {
    onChange(parts(text, between));
    const unclear = doubt(text, between);
    const choice = (/** @type {string} */ list, /** @type {string} */ words) =>
      smallButton(words, () => ((box.value = list), typed(list)));
    fill(
      asks,
      unclear && [
        `${unclear.question} `,
        choice(unclear.decimal, "One number"),
        " ",
        choice(unclear.list, "Two values"),
      ],
    );
  }

  return [box, asks];
}
