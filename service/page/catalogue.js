/** Every question that a study answers: what it is, and its name on the command line, in Python and in an address. */

import { el } from "./dom.js";
import { AMPLITUDE, RECORD } from "./selection.js";
import { WORDS } from "./words.js";

/** @param {any} record @returns {HTMLElement} */
export function catalogue({ dimensions }) {
  const kind = dimensions.includes(RECORD) ? "suite" : dimensions.includes(AMPLITUDE) ? "amplitudes" : "harmonic";
  const rows = WORDS.questions
    .filter(({ kinds }) => kinds.includes(kind))
    .map(({ summary, command, method, route }) => {
      const ways = [`damperlab ${command}`, `.${method}()`, `/${route}`].map((way) => el("td", {}, el("code", {}, way)));
      return el("tr", {}, el("th", { scope: "row" }, summary), ways);
    });
  const head = ["Question", "Command", "Python", "HTTP"].map((text) => el("th", { scope: "col" }, text));
  return el(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": "Every question that the study answers" },
    el("table", { class: "catalogue" }, el("thead", {}, el("tr", {}, head)), el("tbody", {}, rows)),
  );
}
