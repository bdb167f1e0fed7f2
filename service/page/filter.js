/** Filters a list by name and state, and studies also by tag and range. The address keeps the filter. */
/** @import { Child, Kept } from "./types.js" */

import { debounced, el, fill, picker } from "./dom.js";
import { TAG } from "./remarks.js";
import { LENGTH_IN_SI, MILLIMETRES } from "./shown.js";
import { titled } from "./vocabulary.js";
import { WORDS } from "./words.js";

/** The dimensions of all kinds of study, without repetitions. */
const AXES = [...new Set([...WORDS.axes, ...WORDS.amplitude_axes, ...WORDS.suite_axes])];
/** The choice in the picker of states that lists deleted items. */
const TRASH = "trash";

export class Filter {
  /** @param {Kept} kept @param {() => void} look called when the filter changes */
  constructor(kept, look) {
    const { name = "" } = kept.values;
    /** @type {Record<string, string>} */
    this.found = { name, state: kept.one("state", [...WORDS.states, TRASH], "") };
    this.changed = () => (kept.keep(this.found), look());
    this.soon = debounced(250, this.changed);
    const states = /** @type {[string, string][]} */ ([
      ["", "any state"],
      ...WORDS.states.map((state) => [state, state]),
      [TRASH, "in the trash"],
    ]);
    this.row = el(
      "div",
      { class: "row" },
      this.typed("name", "Search", { type: "search", placeholder: "part of a name" }).field,
      picker("State", states, this.found.state, (state) => ((this.found.state = state), this.changed())),
    );
  }

  /** @param {string} what @param {string} label @param {Record<string, unknown>} attributes of the box */
  typed(what, label, attributes) {
    const oninput = () => ((this.found[what] = input.value.trim()), this.soon());
    const input = el("input", { ...attributes, value: this.found[what], oninput });
    return { input, field: el("label", { class: "field" }, el("span", {}, label), input) };
  }

  /** @param {string} label @param {Child} [more] */
  form(label, more) {
    const onsubmit = (/** @type {Event} */ event) => event.preventDefault();
    return el("form", { class: "fields", role: "search", "aria-label": label, onsubmit }, this.row, more);
  }

  /** Whether the trash is listed. */
  gone = () => this.found.state === TRASH;

  /** Whether any filter is set. */
  isUsed() {
    return Object.values(this.found).some(Boolean);
  }

  /** The filter as parameters of the request for a list. @returns {Record<string, unknown>} */
  wanted() {
    return { ...this.found, state: this.gone() ? "" : this.found.state, trash: this.gone() || null };
  }

  /** The reason why nothing can match the filter, if this is known without a request; otherwise empty. */
  nothing() {
    return "";
  }
}

/** The filter of the list of studies. The ends of the range are in the unit of the label. */
export class StudyFilter extends Filter {
  /** @param {Kept} kept @param {() => void} look */
  constructor(kept, look) {
    super(kept, look);
    const { tag = "", from = "", to = "" } = kept.values;
    Object.assign(this.found, { tag, axis: kept.one("axis", AXES, ""), from, to });
    const { found } = this;
    const axes = /** @type {[string, string][]} */ ([
      ["", "any"],
      ...AXES.map((axis) => [axis, titled(axis)]),
    ]);
    this.tag = this.typed("tag", "Tag", {
      type: "search",
      placeholder: "a whole tag",
      autocapitalize: "none",
    });
    this.ends = el("span", { class: "row" });
    this.more = el(
      "details",
      { class: "more", open: Boolean(found.tag || found.axis) },
      el("summary", {}, "More filters"),
      el(
        "div",
        { class: "row" },
        this.tag.field,
        picker("Values of", axes, found.axis, (axis) => this.over(axis)),
        this.ends,
      ),
    );
    this.drawEnds();
  }

  drawEnds() {
    const number = { type: "number", step: "any" };
    const fields = [this.typed("from", "from", number).field, this.typed("to", "to", number).field];
    fill(this.ends, this.found.axis && fields);
  }

  /** Choose the parameter of the range. @param {string} axis */
  over(axis) {
    Object.assign(this.found, { axis, from: "", to: "" });
    this.drawEnds();
    this.changed();
  }

  /** Show the studies with a tag. @param {string} tag */
  tagged(tag) {
    this.more.open = true;
    this.tag.input.value = this.found.tag = tag;
    this.changed();
  }

  wanted() {
    const { axis, from, to } = this.found;
    const scale = LENGTH_IN_SI.test(axis) ? MILLIMETRES : 1;
    const inSi = (/** @type {string} */ end) => (end === "" || !axis ? "" : Number(end) / scale);
    return { ...super.wanted(), from: inSi(from), to: inSi(to) };
  }

  nothing() {
    const { tag, axis, from, to } = this.found;
    if (tag && !TAG.test(tag)) return `No study has such a tag: a tag has ${WORDS.tag_words}.`;
    return axis && from && to && Number(from) > Number(to)
      ? "The range is empty: its end is below its start."
      : "";
  }
}
