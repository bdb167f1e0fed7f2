/** Dampers of fixed force and clearance, judged by their worst case while the base moves more or less than planned. */

import { ask, refusalBox, studyPath } from "./api.js";
import { el, fill, prose } from "./dom.js";
import { VALUE } from "./headline.js";
import { short } from "./numbers.js";
import { FREQUENCY } from "./selection.js";

const TOP = 5;

/**
 * @param {import("./study.js").Session} session
 * @param {() => Record<string, any>} judged how designs are judged now, as the ranking above is asked for
 * @param {(design: any) => void} go shows a design on the map
 */
export function robustPanel({ record, selection, shown }, judged, go) {
  const number = { type: "number", step: "any", min: 0 };
  const low = el("input", { ...number, value: "0.5" });
  const high = el("input", { ...number, value: "2" });
  const told = el("div");
  const columns = selection.varied.filter((name) => name !== FREQUENCY);

  /** @param {Event} event */
  async function look(event) {
    event.preventDefault();
    try {
      const answer = await ask(studyPath(record.id, "robust-designs"), { ...judged(), amplitudes: `${low.value},${high.value}`, top: TOP });
      fill(told, answer.designs.length ? table(answer.designs) : null, el("p", { class: "quiet note" }, prose(shown.words(answer).note)));
    } catch (error) {
      fill(told, refusalBox(error));
    }
  }

  /** @param {any[]} designs */
  function table(designs) {
    const unit = shown.has(VALUE) ? ` [${shown.unit(VALUE).trim()}]` : "";
    const head = [`Worst${unit}`, `As planned${unit}`, "Worst at"].map((text) => el("th", { scope: "col" }, text));
    const rows = designs.map((design, i) =>
      el(
        "tr",
        {},
        el("td", {}, shown.withError(VALUE, design.value, design.error)),
        el("td", {}, design.nominal === null ? "–" : short(design.nominal * shown.factor(VALUE))),
        el("td", {}, `${short(design.amplitude, 3)} times the amplitude`),
        columns.map((name) => el("td", {}, short(design[name] * shown.factor(name)))),
        el("td", {}, el("button", { type: "button", class: "small", "aria-label": `Show robust design ${i + 1} on the map`, onclick: () => go(design) }, "Show")),
      ),
    );
    const named = columns.map((name) => el("th", { scope: "col", title: shown.title(name) }, shown.symbol(name), shown.has(name) && ` [${shown.unit(name).trim()}]`));
    return el(
      "div",
      { class: "scroll", tabindex: 0, role: "region", "aria-label": "Robust designs" },
      el("table", {}, el("thead", {}, el("tr", {}, head, named, el("th", { scope: "col" }, "On the map"))), el("tbody", {}, rows)),
    );
  }

  return el(
    "details",
    { class: "more" },
    el("summary", {}, "Robust: what if the base moves more, or less?"),
    el("p", { class: "quiet" }, "A damper that is built keeps its friction force and its clearance. While the base amplitude varies, both ratios change together; the dampers below are best in their worst case."),
    el(
      "form",
      { class: "row controls", onsubmit: look },
      el("label", { class: "field" }, el("span", {}, "From … times the amplitude"), low),
      el("label", { class: "field" }, el("span", {}, "to … times"), high),
      el("button", { type: "submit" }, "Judge the worst case"),
    ),
    told,
  );
}

/** Whether a study has what such a judgement needs: both ratios of a damper, or friction alone where there is no particle. @param {import("./study.js").Session} session */
export function canBeRobust({ selection, record }) {
  const needed = record.definition.particle === false ? ["friction_ratio"] : ["clearance_ratio", "friction_ratio"];
  return needed.every((name) => selection.varied.includes(name));
}
