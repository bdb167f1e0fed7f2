/** Which dimensions a map lies over. */

import { picker } from "./dom.js";

/**
 * Pickers of both; one that takes the other's dimension gives it its own.
 *
 * @param {[string, string][]} names value and text of each dimension
 * @param {{x: string, y: string}} view changed by them
 * @param {() => void} changed
 */
export function axisPickers(names, view, changed) {
  /** @param {"x" | "y"} mine @param {"x" | "y"} other */
  const exchange = (mine, other) => (/** @type {string} */ name) => {
    if (view[other] === name) view[other] = view[mine];
    view[mine] = name;
    changed();
  };
  return [
    picker("Across", names, view.x, exchange("x", "y")),
    picker("Up", names, view.y, exchange("y", "x")),
  ];
}
