/** Searches with follow-up studies, for a better design and for the largest friction of the particle. */
/** @import { Refinement, Session } from "./types.js" */

import { ask, refusalBox, send, studyPath } from "./api.js";
import { button, el, fill, prose, quiet, say } from "./dom.js";
import { VALUE } from "./headline.js";
import { short } from "./numbers.js";
import { progressBar } from "./progress.js";
import { FREQUENCY } from "./selection.js";
import { WORDS } from "./words.js";

const LOOK_MILLISECONDS = 500;
/** Kind of note whose text is the same in units and in ratios. */
const FRICTION = "particle_friction";

export class RefinePanel {
  told = el("div", { role: "status" });
  stopped = false;
  /** The computed follow-up studies. @type {{id: string}[]} */
  rounds = [];

  /**
   * @param {Session} session
   * @param {() => Record<string, unknown>} judged function that returns the criteria of the shown ranking
   */
  constructor(session, judged) {
    this.session = session;
    this.judged = judged;
    const stop = () => (this.stop.disabled = this.stopped = true);
    this.buttons = [
      button("Search around the best design", () => this.search("refine")),
      button("Find the particle friction it tolerates", () => this.search("particle-friction")),
    ];
    this.stop = button("Stop", stop);
    this.stop.disabled = true;
    this.element = el(
      "details",
      { class: "more" },
      el("summary", {}, "Refine: is a better design nearby?"),
      quiet(
        "Computes further designs between those of the grid, in separate studies, until none can be " +
          "better by 1 % or 20,000 points are spent. The friction of the particle is found by computing " +
          "the best design with several coefficients. Computed points are kept, so a stopped search " +
          "continues from there.",
      ),
      el("div", { class: "row" }, this.buttons, this.stop),
      this.told,
    );
  }

  get over() {
    return this.stopped || !this.element.isConnected;
  }

  /** @param {"refine" | "particle-friction"} what */
  async search(what) {
    for (const one of this.buttons) one.disabled = true;
    this.stop.disabled = this.stopped = false;
    this.rounds = [];
    try {
      let further = await this.ask(what);
      while (further.length) {
        for (const study of further) {
          await this.ended(study);
          if (this.over) return;
          this.rounds.push(study);
        }
        further = await this.ask(what);
      }
      say("The search has ended.");
    } catch (error) {
      this.told.append(refusalBox(error));
    } finally {
      for (const one of this.buttons) one.disabled = false;
      this.stop.disabled = true;
    }
  }

  /**
   * Request the state of a search and show it. Return the follow-up studies that remain to be computed.
   *
   * @param {"refine" | "particle-friction"} what
   */
  async ask(what) {
    const { rounds } = this;
    const known = rounds.map(({ id }) => id);
    const path = studyPath(this.session.record.id, what);
    const answer = await send(path, {}, { ...this.judged(), with: known.join(",") });
    fill(this.told, this.outcome(answer));
    return (answer.follow_ups ?? []).filter(({ id }) => !known.includes(id));
  }

  /** Wait until a study has ended, and show its progress. @param {{id: string}} study */
  async ended(study) {
    const words = this.told.appendChild(el("p", {}));
    for (;;) {
      const now = await ask(studyPath(study.id));
      fill(words, progressBar(now));
      if (WORDS.ended.includes(now.state)) {
        if (now.state !== "done")
          throw new Error(`the follow-up study ${study.id} is ${now.state}. ${now.message ?? ""}`);
        return;
      }
      if (this.over) return;
      await new Promise((go) => setTimeout(go, LOOK_MILLISECONDS));
    }
  }

  /** @param {Refinement} answer */
  outcome({ found, known, steps, note, notes }) {
    const { selection, shown } = this.session;
    const named = selection.varied.filter((name) => name !== FREQUENCY);
    const step = (/** @type {string} */ name) =>
      steps[name] ? ` ± ${short(steps[name] * shown.factor(name), 2)}` : "";
    const at = named.flatMap((name, i) => [
      i > 0 && ", ",
      el("span", { class: "one" }, shown.symbol(name), ` = ${shown.value(name, found[name])}`, step(name)),
    ]);
    const best = el("strong", {}, shown.withError(VALUE, found.value, found.error) + shown.unit(VALUE));
    const { length } = this.rounds;
    const { id } = this.rounds[length - 1] ?? {};
    return [
      el("p", {}, known ? "Known: " : "So far: ", best, " at ", at, "."),
      (!shown.inUnits || notes.every(({ kind }) => kind === FRICTION)) && quiet(prose(note)),
      id &&
        quiet(
          `${length} follow-up ${length === 1 ? "study" : "studies"} computed; the last is `,
          el("a", { href: `#/studies/${id}` }, id),
          ".",
        ),
    ];
  }
}
