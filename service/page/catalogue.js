/** Every question that a study answers: what it is, and how a command, a program and another machine ask it. */

import { address, studyPath } from "./api.js";
import { el } from "./dom.js";
import { AMPLITUDE, RECORD } from "./selection.js";
import { WORDS } from "./words.js";

/** @param {any} record @returns {HTMLElement} */
export function catalogue({ id, dimensions }) {
  const kind = dimensions.includes(RECORD) ? "suite" : dimensions.includes(AMPLITUDE) ? "amplitudes" : "harmonic";
  const rows = WORDS.questions
    .filter(({ kinds }) => kinds.includes(kind))
    .map(({ summary, command, method, route }) => {
      const ways = [`damperlab ${command} ${id}`, `study.${method}()`, address(studyPath(id, route)).pathname];
      return el("tr", {}, el("th", { scope: "row" }, summary), ways.map((way) => el("td", {}, el("code", {}, way))));
    });
  const head = ["Question", "Command", "Python", "HTTP"].map((text) => el("th", { scope: "col" }, text));
  return el(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": "Every question that the study answers" },
    el("table", { class: "catalogue" }, el("thead", {}, el("tr", {}, head)), el("tbody", {}, rows)),
  );
}
