/**
 * What the list of studies shows: part of a name, a state, a tag, a range of a parameter; kept in the
 * address.
 */

import { debounced, el, fill, picker } from "./dom.js";
import { LENGTH_IN_SI, MILLIMETRES } from "./shown.js";
import { titled } from "./vocabulary.js";
import { WORDS } from "./words.js";

/** The dimensions of every kind of study, each once. */
const AXES = [...new Set([...WORDS.axes, ...WORDS.amplitude_axes, ...WORDS.suite_axes])];
/** Stands for no state, but for where studies are that were deleted. */
const TRASH = "trash";
const TAG = new RegExp(`^(?:${WORDS.tag_pattern})$`);

/**
 * @typedef {{name: string, state: string, tag: string, axis: string, from: string, to: string}} Wanted ends
 *   of a range in the unit of the label
 */

/**
 * @param {import("./kept.js").Kept} kept
 * @param {() => void} look called when something else is wanted
 * @returns {{element: HTMLElement, row: HTMLElement, wanted: () => Record<string, any>, any: () => boolean,
 *   gone: () => boolean, nothing: () => string, tagged: (tag: string) => void}} `nothing` says why no study
 *   can be meant, where that is known without asking
 */
export function studyFilter(kept, look) {
  const { name = "", tag = "", from = "", to = "" } = kept.values;
  /** @type {Wanted} */
  const found = {
    name,
    state: kept.one("state", [...WORDS.states, TRASH], ""),
    tag,
    axis: kept.one("axis", AXES, ""),
    from,
    to,
  };
  const changed = () => (kept.keep(found), look());
  const soon = debounced(250, changed);
  /**
   * @param {"name" | "tag" | "from" | "to"} what
   * @param {string} label
   * @param {Record<string, unknown>} attributes
   */
  const typed = (what, label, attributes) => {
    const input = el("input", {
      ...attributes,
      value: found[what],
      oninput: () => ((found[what] = input.value.trim()), soon()),
    });
    return { input, field: el("label", { class: "field" }, el("span", {}, label), input) };
  };
  const states = /** @type {[string, string][]} */ ([
    ["", "any state"],
    ...WORDS.states.map((state) => [state, state]),
    [TRASH, "in the trash"],
    ,
  ]);
  const axes = /** @type {[string, string][]} */ ([["", "any"], ...AXES.map((axis) => [axis, titled(axis)])]);
  const tagged = typed("tag", "Tag", { type: "search", placeholder: "a whole tag", autocapitalize: "none" });
  const ends = el("span", { class: "row" });
  const more = el(
    "details",
    { class: "more", open: Boolean(found.tag || found.axis) },
    el("summary", {}, "More filters"),
    el("div", { class: "row" }, tagged.field, picker("Values of", axes, found.axis, chosen), ends),
  );

  function drawEnds() {
    const number = { type: "number", step: "any" };
    fill(ends, found.axis && [typed("from", "from", number).field, typed("to", "to", number).field]);
  }

  /** @param {string} axis */
  function chosen(axis) {
    Object.assign(found, { axis, from: "", to: "" });
    drawEnds();
    changed();
  }

  /** @param {string} end in the unit of the label */
  const inSi = (end) =>
    end === "" || !found.axis ? "" : Number(end) / (LENGTH_IN_SI.test(found.axis) ? MILLIMETRES : 1);

  const gone = () => found.state === TRASH;
  drawEnds();
  const row = el(
    "div",
    { class: "row" },
    typed("name", "Search", { type: "search", placeholder: "part of a name" }).field,
    picker("State", states, found.state, (state) => ((found.state = state), changed())),
  );
  return {
    row,
    element: el(
      "form",
      {
        class: "fields",
        role: "search",
        "aria-label": "Studies",
        onsubmit: (/** @type {Event} */ event) => event.preventDefault(),
      },
      row,
      more,
    ),
    wanted: () => ({
      ...found,
      state: gone() ? "" : found.state,
      trash: gone() || null,
      from: inSi(found.from),
      to: inSi(found.to),
    }),
    gone,
    any: () => Object.values(found).some(Boolean),
    nothing: () => {
      if (found.tag && !TAG.test(found.tag)) return `No study has such a tag: a tag has ${WORDS.tag_words}.`;
      return found.axis && found.from && found.to && Number(found.from) > Number(found.to)
        ? "The range holds nothing: it ends below where it begins."
        : "";
    },
    tagged: (one) => {
      more.open = true;
      tagged.input.value = found.tag = one;
      changed();
    },
  };
}
