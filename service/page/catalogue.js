/** Every question that a study answers: what it is, and its name as a command, in Python and over HTTP. */
/** @import { StudyRecord } from "./types.js" */

import { el } from "./dom.js";
import { AMPLITUDE, RECORD } from "./selection.js";
import { WORDS } from "./words.js";

/** @param {StudyRecord} record */
export function catalogue({ dimensions }) {
  const beside = dimensions.includes(AMPLITUDE) ? "amplitudes" : "harmonic";
  const kind = dimensions.includes(RECORD) ? "suite" : beside;
  const rows = WORDS.questions
    .filter(({ kinds }) => kinds.includes(kind))
    .map(({ summary, command, method, route }) => {
      const names = [`damperlab ${command}`, `.${method}()`, `/${route}`];
      const ways = names.map((name) => el("td", {}, el("code", {}, name)));
      return el("tr", {}, el("th", { scope: "row" }, summary), ways);
    });
  const titles = ["Question", "Command", "Python", "HTTP"];
  const head = titles.map((text) => el("th", { scope: "col" }, text));
  return el(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": "Every question that the study answers" },
    el("table", { class: "catalogue" }, el("thead", {}, el("tr", {}, head)), el("tbody", {}, rows)),
  );
}
