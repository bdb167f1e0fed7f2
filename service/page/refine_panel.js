/**
 * A search around the best design: follow-up studies, submitted and waited for until the best is known well
 * enough.
 */
/** @import { Refinement, Session } from "./types.js" */

import { ask, refusalBox, send, studyPath } from "./api.js";
import { el, fill, prose, say } from "./dom.js";
import { VALUE } from "./headline.js";
import { counted, short } from "./numbers.js";
import { progressBar } from "./progress.js";
import { FREQUENCY } from "./selection.js";
import { WORDS } from "./words.js";

const LOOK_MILLISECONDS = 500;

/**
 * @param {Session} session
 * @param {() => Record<string, unknown>} judged how designs are judged now, as the ranking above is asked for
 */
export function refinePanel({ record, selection, shown }, judged) {
  const told = el("div", { role: "status" });
  const button = el("button", { type: "button", onclick: search }, "Search around the best design");
  const stop = el(
    "button",
    { type: "button", disabled: true, onclick: () => ((stop.disabled = true), (stopped = true)) },
    "Stop",
  );
  let stopped = false;
  const panel = el(
    "details",
    { class: "more" },
    el("summary", {}, "Refine: is a better design nearby?"),
    el(
      "p",
      { class: "quiet" },
      "Computes further designs between those of the grid, in studies of their own, until none can be " +
        "better by 1 % or 20,000 points are spent. What is computed is kept: a search that was stopped " +
        "goes on from there.",
    ),
    el("div", { class: "row" }, button, stop),
    told,
  );
  const over = () => stopped || !panel.isConnected;

  async function search() {
    button.disabled = true;
    stop.disabled = stopped = false;
    /** @type {{id: string}[]} */
    const rounds = [];
    try {
      for (;;) {
        const asked = { ...judged(), with: rounds.map(({ id }) => id).join(",") };
        const answer = await send(studyPath(record.id, "refine"), {}, asked);
        fill(told, outcome(answer, rounds));
        const further = (answer.follow_ups ?? []).filter(
          (study) => !rounds.some(({ id }) => id === study.id),
        );
        if (further.length === 0) return say("The search around the best design has ended.");
        for (const study of further) {
          await ended(study);
          if (over()) return;
          rounds.push(study);
        }
      }
    } catch (error) {
      told.append(refusalBox(error));
    } finally {
      button.disabled = false;
      stop.disabled = true;
    }
  }

  /** Wait for a study, and say how far it is. @param {{id: string}} study */
  async function ended(study) {
    const words = told.appendChild(el("p", {}));
    for (;;) {
      const now = await ask(studyPath(study.id));
      fill(words, progressBar(now));
      if (WORDS.ended.includes(now.state)) {
        if (now.state !== "done")
          throw new Error(`the follow-up study ${study.id} is ${now.state}. ${now.message ?? ""}`);
        return;
      }
      if (over()) return;
      await new Promise((go) => setTimeout(go, LOOK_MILLISECONDS));
    }
  }

  /** @param {Refinement} answer @param {{id: string}[]} rounds */
  function outcome({ found, known, steps, note }, rounds) {
    const named = selection.varied.filter((name) => name !== FREQUENCY);
    const at = named.flatMap((name, i) => [
      i > 0 && ", ",
      el(
        "span",
        { class: "one" },
        shown.symbol(name),
        ` = ${shown.value(name, found[name])}`,
        steps[name] ? ` ± ${short(steps[name] * shown.factor(name), 2)}` : "",
      ),
    ]);
    const last = rounds[rounds.length - 1];
    return [
      el(
        "p",
        {},
        known ? "Known: " : "So far: ",
        el("strong", {}, shown.withError(VALUE, found.value, found.error) + shown.unit(VALUE)),
        " at ",
        at,
        ".",
      ),
      !shown.inUnits && el("p", { class: "quiet" }, prose(note)),
      last &&
        el(
          "p",
          { class: "quiet" },
          `${counted(rounds.length, "follow-up study").replace("studys", "studies")} computed; the last is `,
          el("a", { href: `#/studies/${last.id}` }, last.id),
          ".",
        ),
    ];
  }

  return panel;
}
