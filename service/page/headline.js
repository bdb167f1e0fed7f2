/** The box at the top of a study: the recommended design, or the reason why no design is recommended yet. */
/** @import { Frequencies, Ranked, Ranking, Session, Shown } from "./types.js" */

import { capital, el, prose, quiet } from "./dom.js";
import { count, short } from "./numbers.js";
import { FREQUENCY } from "./selection.js";
import { WORDS } from "./words.js";

/** The result by which designs are judged, at one frequency or over a band. */
export const VALUE = "amplitude_ratio";
/** Computed share of a study below which the best design may still change much. */
const FRAGMENT = 0.5;
/** Doubts that concern every design of a study, not only the optimum. */
const OF_EVERY_DESIGN = ["one_frequency", "hidden_peak"];

/**
 * The recommended design of a study, which usually is the best design. If the friction of the best design
 * clamps the structure, the best design with impacts is recommended instead.
 *
 * @param {Pick<Ranking, "designs" | "best_with_impacts" | "clamped">} ranked the service's ranking
 * @returns {{best: Ranked | null, other: Ranked | null}} `best` is the recommended design. If the best design
 *   has no impacts, there is a second candidate, the best design with impacts; `other` is then the candidate
 *   that is not recommended.
 */
export function leading(ranked) {
  const first = ranked.designs[0] ?? null;
  const striking = first?.impact_share === 0 ? (ranked.best_with_impacts ?? null) : null;
  return striking && ranked.clamped ? { best: striking, other: first } : { best: first, other: striking };
}

/** Whether a tuned mass damper is better than every design of the study. @param {Ranking} ranked */
export function isBeaten(ranked) {
  return ranked.brief.damper === "tuned_mass_damper";
}

/** A box with the recommended design of a ranking. @param {Session} session @param {Ranking} ranked */
export function headline({ record, selection, shown }, ranked) {
  const { best, other } = leading(ranked);
  if (!best) return null;
  const clamps = other !== null && best.impact_share > 0;
  const named = selection.varied.filter((name) => name !== FREQUENCY);
  const at = named.flatMap((name, i) => [
    i > 0 && ", ",
    el("span", { class: "one" }, shown.symbol(name), ` = ${shown.value(name, best[name])}`),
  ]);
  const value = shown.withError(VALUE, best.value, best.error) + shown.unit(VALUE);
  const next = ranked.next_frequencies;
  const judged = shown.has(VALUE) ? WORDS.objectives_in_units[ranked.objective] : ranked.long_name;
  // a study with missing points may still get a better design
  const soFar = record.points_done < record.points_total ? " so far" : "";
  const beaten = isBeaten(ranked);
  const title = beaten
    ? "A tuned mass damper does better"
    : `Best design${clamps ? " with impacts" : ""}`;
  const few = record.points_done < FRAGMENT * record.points_total;
  const doubts = shown
    .words(ranked)
    .doubts.filter(({ kind }) => OF_EVERY_DESIGN.includes(kind) || !(next || clamps || few));
  return el(
    "section",
    { class: "box headline", "aria-label": "Best design" },
    el("h2", {}, next ? "No design is recommended yet" : title + soFar),
    el(
      "p",
      {},
      capital(
        `${beaten && !next ? "best of the study, " : ""}${judged}` +
          `${next && clamps ? ", the least so far with impacts" : ""}: `,
      ),
      el("strong", {}, value),
      named.length > 0 && " at ",
      at,
      ".",
    ),
    few &&
      quiet(
        `Only ${count(record.points_done)} of ${count(record.points_total)} points are computed: a ` +
          "better design is likely among the others.",
      ),
    doubts.map(({ sentence }) => quiet(prose(sentence))),
    other &&
      quiet(
        clamps
          ? `A smaller value, ${shown.value(VALUE, other.value)}, belongs to designs whose friction clamps ` +
              "the structure to its base."
          : `Its particle strikes no wall. The best with impacts has ${shown.value(VALUE, other.value)}.`,
      ),
    judgedOver(record.id, shown, next),
  );
}

/**
 * If only one frequency was computed, a link to the form of a new study with the same designs over a band.
 *
 * @param {string} id
 * @param {Shown} shown
 * @param {Frequencies | null | undefined} next frequencies of the new study; null if the study has a band
 */
export function judgedOver(id, shown, next) {
  if (!next) return null;
  const { start, stop, num } = next;
  const href = `#/new?${new URLSearchParams({ from: id, frequencies: [start, stop, num].join(",") })}`;
  return el(
    "a",
    { class: "button primary", href },
    `Judge it over ${shown.has(FREQUENCY) ? "f" : "r"} = ${short(start * shown.factor(FREQUENCY))} to ` +
      `${shown.value(FREQUENCY, stop)}`,
  );
}
