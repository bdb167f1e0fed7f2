/** Which parameter matters: shares of a result's variance over the grid, as bars. */

import { ask, refusalBox, studyPath } from "./api.js";
import { el, fill, prose } from "./dom.js";
import { chosenMeasure } from "./measures.js";
import { short } from "./numbers.js";

/** @param {import("./study.js").Session} session @returns {{element: HTMLElement, look: () => void}} */
export function importancePanel(session) {
  const { record, shown } = session;
  const result = chosenMeasure(session, "matters", () => look());
  const table = el("div");
  let asked = 0;

  async function look() {
    const mine = ++asked;
    const metric = result.get();
    try {
      const found = await ask(studyPath(record.id, "importance"), { metric });
      if (mine !== asked) return;
      const rows = found.dimension.map((/** @type {string} */ name, /** @type {number} */ i) => [
        shown.title(name),
        found.share[i],
        short(found.effect[i] === null ? null : found.effect[i] * shown.factor(metric)) + shown.unit(metric),
      ]);
      fill(
        table,
        bars([...rows, ["Combinations of parameters", found.interactions, ""]]),
        el("p", { class: "quiet note" }, prose(shown.words(found).note)),
      );
    } catch (error) {
      if (mine === asked) fill(table, refusalBox(error));
    }
  }

  const element = el(
    "section",
    { class: "box" },
    el("h2", {}, "What matters"),
    el("div", { class: "row controls" }, result.element),
    table,
  );
  return { element, look };
}

/** @param {[string, number | null, string][]} rows */
function bars(rows) {
  const head = ["Parameter", "Share of the variance", "Span of the mean"].map((text) =>
    el("th", { scope: "col" }, text),
  );
  const body = rows.map(([name, share, effect]) => {
    const percent = share === null ? null : 100 * share;
    const bar =
      percent !== null &&
      el("span", { class: "bar", style: `width: ${Math.min(100, Math.max(0, percent)).toFixed(1)}%` });
    return el(
      "tr",
      {},
      el("th", { scope: "row" }, name),
      el("td", { class: "bars" }, bar, el("span", {}, percent === null ? "–" : `${short(percent, 2)} %`)),
      el("td", {}, effect),
    );
  });
  return el(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": "Importance of each parameter" },
    el("table", { class: "importance" }, el("thead", {}, el("tr", {}, head)), el("tbody", {}, body)),
  );
}
