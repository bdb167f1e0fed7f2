/** Lists as they are typed: values with commas, semicolons or spaces between them. */

import { el, fill, smallButton } from "./dom.js";

/** One comma between two digits and no further one: a decimal comma, or two values. */
const EITHER = /(?<=^|\s)[+-]?\d+,\d+(?=\s|$)/;
/** What stands between two values where no comma does; a value that has a name may have spaces in it. */
const SPACES = /[;\s]+/;
export const SEMICOLON = /;/;

/**
 * The parts of a list. "0,2" stays one part, since nobody can tell what it means; "1,2,3" and "0.2,0.5" are
 * lists.
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
 * What to ask about a list, and what it is either way; null where it is plain.
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
 * @param {(parts: string[]) => void} onChange told the parts of what is typed
 * @param {Record<string, unknown>} [attributes] of the box
 * @param {RegExp} [between] as `parts` takes it
 * @returns {HTMLElement[]} the box, and where it asks
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
