/**
 * Tables of the best designs of a study and of its Pareto front, with buttons that select the designs.
 *
 * @typedef {Ranked & {text: string}} Marked
 * @typedef {{best: Marked | null, other: Marked | null, pareto: Marked[], ranked: Ranking | null}} Found with
 *   `ranked`, the answer of the service
 */
/** @import { Ranked, Ranking, Session, Shown } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { checkbox, details, el, fill, grid, picker, prose, smallButton } from "./dom.js";
import { leading, VALUE } from "./headline.js";
import { help } from "./help.js";
import { short } from "./numbers.js";
import { RefinePanel } from "./refine_panel.js";
import { FREQUENCY } from "./selection.js";
import { WORDS } from "./words.js";

const TOP = 5;
const FRONT = 50;
/** @type {Found} */
export const NOTHING_FOUND = { best: null, other: null, pareto: [], ranked: null };

export class DesignsPanel {
  table = el("div");
  front = el("div");
  number = 0;

  /** @param {Session} session @param {(found: Found) => void} onFound */
  constructor(session, onFound) {
    this.session = session;
    this.onFound = onFound;
    const { selection, kept, changes } = session;
    this.usual = selection.varied.includes(FREQUENCY) ? "peak" : "resonance";
    this.objectives = objectivesOf(session);
    this.respects = respectsOf(session);
    const [objectives, respects] = [this.objectives, this.respects].map((each) => each.map(([name]) => name));
    this.asked = {
      objective: kept.one("objective", objectives, this.usual),
      exclude_locked: kept.on("exclude_locked", false),
      against: kept.one("pareto", respects, ""),
    };
    this.element = this.section();
    changes.addEventListener("grown", () => this.table.isConnected && this.look());
    this.look();
  }

  section() {
    const { asked, objectives, respects } = this;
    const against = /** @type {[string, string][]} */ ([["", "nothing"], ...respects]);
    return el(
      "section",
      { class: "box designs" },
      help("how-to/best-design/", "finding the best design"),
      el("h2", {}, "Designs"),
      el(
        "div",
        { class: "row controls" },
        picker("Judged by", objectives, asked.objective, (objective) => this.change({ objective })),
        picker("Pareto front against", against, asked.against, (one) => this.change({ against: one })),
        checkbox("Leave out locked designs", asked.exclude_locked, (on) =>
          this.change({ exclude_locked: on }),
        ),
      ),
      this.table,
      this.front,
      new RefinePanel(this.session, () => this.judged()).element,
    );
  }

  /** The present criteria for judging designs. */
  judged() {
    const { objective, exclude_locked } = this.asked;
    return { objective, exclude_locked };
  }

  /** @param {Partial<typeof this.asked>} what */
  change(what) {
    Object.assign(this.asked, what);
    const { objective, exclude_locked, against } = this.asked;
    this.session.kept.keep({
      objective: objective === this.usual ? null : objective,
      exclude_locked: exclude_locked || null,
      pareto: against,
    });
    this.look();
  }

  async look() {
    const mine = ++this.number;
    const { record, selection } = this.session;
    const { against } = this.asked;
    const question = this.judged();
    let found = NOTHING_FOUND;
    try {
      const path = studyPath(record.id, "optimal-designs");
      const ranked = await ask(path, { ...question, top: TOP });
      const pareto = against
        ? await ask(path, { ...question, top: FRONT, pareto: `amplitude,${against}` })
        : null;
      if (mine !== this.number) return;
      found = this.marked(ranked, pareto?.designs ?? []);
      fill(this.table, this.listed(ranked, "Best designs"));
      fill(this.front, pareto && this.listed(pareto, "Pareto front", against));
    } catch (error) {
      if (mine !== this.number) return;
      fill(this.table, refusalBox(error));
      fill(this.front);
    }
    if (found.best) selection.rest(found.best);
    this.onFound(found);
  }

  /** @param {Ranking} ranked @param {Ranked[]} pareto @returns {Found} */
  marked(ranked, pareto) {
    const { shown } = this.session;
    const { best, other } = leading(ranked);
    const called = (/** @type {Ranked} */ design) =>
      design.impact_share > 0 ? "Best with impacts" : "Best, no impact";
    return {
      best: best && named(best, other && best.impact_share > 0 ? called(best) : "Optimum", shown),
      other: other && named(other, called(other), shown),
      pareto: pareto.map((design) => named(design, "Pareto front", shown)),
      ranked,
    };
  }

  /** @param {Ranking} answer @param {string} title @param {string} [against] */
  listed(answer, title, against) {
    const { selection, shown, words } = this.session;
    const columns = selection.varied.filter((name) => name !== FREQUENCY);
    // a quantity that already has a column is not shown twice
    const respect = against && columns.includes(WORDS.respects[against]) ? undefined : against;
    const heads = [
      `Value${shown.inBrackets(VALUE)}`,
      ...columns.map((name) => this.head(name)),
      ...(respect ? [respectIn(shown, respect, words.respects[respect])] : []),
      "Response",
      "On the map",
    ];
    const rows = answer.designs.map((design, i) => [
      shown.withError(VALUE, design.value, design.error),
      ...columns.map((name) => short(design[name] * shown.factor(name))),
      ...(respect ? [shown.value(WORDS.respects[respect], design[respect])] : []),
      design.response_class.replaceAll("_", " "),
      this.show(design, `Show design ${i + 1} of ${title} on the map`),
    ]);
    const { verdict, note } = shown.words(answer);
    return [
      el("h3", {}, title),
      grid(title, heads, rows, false),
      verdict.map((sentence) => el("p", {}, prose(sentence))),
      details("How they were judged", el("p", { class: "quiet note" }, prose(note))),
    ];
  }

  /** @param {string} name of a column */
  head(name) {
    const { shown } = this.session;
    return el("span", { title: shown.title(name) }, shown.symbol(name), shown.inBrackets(name));
  }

  /** @param {Ranked} design @param {string} says */
  show(design, says) {
    return smallButton("Show", () => this.session.selection.chooseDesign(design), says);
  }
}

/** The criteria for judging designs, named for ratios or for values in units. @param {Session} session */
function objectivesOf({ selection, shown, words }) {
  const band = selection.varied.includes(FREQUENCY);
  const texts = shown.has(VALUE) ? WORDS.objectives_in_units : words.objectives;
  return Object.entries(texts).filter(([name]) => band || name === "resonance");
}

/** The second criteria that a Pareto front of the study can have. @param {Session} session */
function respectsOf({ selection, shown, words, variables }) {
  const useful = (/** @type {string} */ source) =>
    source in selection.axes ? selection.varied.includes(source) : variables.includes(source);
  return Object.entries(words.respects)
    .filter(([name]) => name !== "amplitude" && useful(WORDS.respects[name]))
    .map(([name, text]) => /** @type {[string, string]} */ ([name, respectIn(shown, name, text)]));
}

/**
 * The name of a second criterion. If its quantity is shown in units, the name is the title of the quantity.
 *
 * @param {Shown} shown
 * @param {string} respect
 * @param {string} text
 */
function respectIn(shown, respect, text) {
  const source = WORDS.respects[respect];
  return shown.has(source) ? shown.title(source) : text;
}

/** @param {Ranked} design @param {string} title @param {Shown} shown */
function named(design, title, shown) {
  return Object.assign({ text: `${title}: ${shown.value(VALUE, design.value)}` }, design);
}
