/** A box for a list, which asks what "0,2" means. */

import { el, fill } from "./dom.js";
import { doubt, parts } from "./lists.js";

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
      el(
        "button",
        { type: "button", class: "small", onclick: () => ((box.value = list), typed(list)) },
        words,
      );
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
