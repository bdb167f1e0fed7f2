/** Reads typed lists, in which commas, semicolons or spaces separate the values. */

import { el, fill, smallButton } from "./dom.js";

/** Pattern of a single comma between digits, which is a decimal comma or separates two values. */
const EITHER = /(?<=^|\s)[+-]?\d+,\d+(?=\s|$)/;
/** Separators of numbers, besides commas. */
const SPACES = /[;\s]+/;
/** Separator of values with names, besides commas. Such values contain spaces, as in `rubber 0.3`. */
export const SEMICOLON = /;/;

/**
 * The parts of a typed list. "0,2" stays one part, because its meaning is unclear; "1,2,3" has three parts.
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
 * A question about an unclear list, with the two ways to read the list; null if the list is clear.
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
 * @param {Record<string, unknown>} [attributes] attributes of the box
 * @param {RegExp} [between] separators, as in `parts`
 * @returns {HTMLElement[]} the box, and the place for a question about an unclear list
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
