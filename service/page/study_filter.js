/** What the list of studies shows: part of a name, a state, a tag, a range of a parameter. */

import { debounced, el, fill, picker } from "./dom.js";
import { LENGTH_IN_SI, MILLIMETRES } from "./shown.js";
import { titled } from "./vocabulary.js";
import { WORDS } from "./words.js";

/** The dimensions of every kind of study, each once. */
const AXES = [...new Set([...WORDS.axes, ...WORDS.amplitude_axes, ...WORDS.suite_axes])];

/** @typedef {{name: string, state: string, tag: string, axis: string, from: string, to: string}} Wanted */

/**
 * @param {() => void} look called when something else is wanted
 * @returns {{element: HTMLElement, wanted: () => Record<string, any>, any: () => boolean, tagged: (tag: string) => void}}
 */
export function studyFilter(look) {
  /** @type {Wanted} */
  const found = { name: "", state: "", tag: "", axis: "", from: "", to: "" };
  const soon = debounced(250, look);
  /** @param {"name" | "tag" | "from" | "to"} what @param {string} label @param {Record<string, any>} attributes */
  const typed = (what, label, attributes) => {
    const input = el("input", { ...attributes, oninput: () => ((found[what] = input.value.trim()), soon()) });
    return { input, field: el("label", { class: "field" }, el("span", {}, label), input) };
  };
  const states = /** @type {[string, string][]} */ ([["", "any state"], ...WORDS.states.map((state) => [state, state])]);
  const axes = /** @type {[string, string][]} */ ([["", "any"], ...AXES.map((axis) => [axis, titled(axis)])]);
  const tag = typed("tag", "Tag", { type: "search", placeholder: "a whole tag", autocapitalize: "none" });
  const ends = el("span", { class: "row" });
  const more = el(
    "details",
    { class: "more" },
    el("summary", {}, "More filters"),
    el("div", { class: "row" }, tag.field, picker("Values of", axes, "", chosen), ends),
  );

  /** @param {string} axis */
  function chosen(axis) {
    Object.assign(found, { axis, from: "", to: "" });
    const number = { type: "number", step: "any" };
    fill(ends, axis && [typed("from", "from", number).field, typed("to", "to", number).field]);
    look();
  }

  /** @param {string} typedEnd in the unit of the label */
  const inSi = (typedEnd) => (typedEnd === "" ? "" : Number(typedEnd) / (LENGTH_IN_SI.test(found.axis) ? MILLIMETRES : 1));

  return {
    element: el(
      "form",
      { class: "fields", role: "search", "aria-label": "Studies", onsubmit: (/** @type {Event} */ event) => event.preventDefault() },
      el("div", { class: "row" }, typed("name", "Search", { type: "search", placeholder: "part of a name" }).field, picker("State", states, "", (state) => ((found.state = state), look()))),
      more,
    ),
    wanted: () => ({ ...found, from: inSi(found.from), to: inSi(found.to) }),
    any: () => Object.values(found).some(Boolean),
    tagged: (name) => {
      more.open = true;
      tag.input.value = found.tag = name;
      look();
    },
  };
}
