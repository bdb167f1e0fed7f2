/**
 * The best designs of a study and its Pareto front, as tables that lead to their points.
 *
 * @typedef {Ranked & {text: string}} Marked
 * @typedef {{best: Marked | null, idle: Marked | null, pareto: Marked[], ranked: Ranking | null}} Found with
 *   the ranking itself
 */
/** @import { Ranked, Ranking, Session, Shown } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { checkbox, el, fill, grid, picker, prose } from "./dom.js";
import { leading, VALUE } from "./headline.js";
import { help } from "./help.js";
import { short } from "./numbers.js";
import { refinePanel } from "./refine_panel.js";
import { FREQUENCY } from "./selection.js";

const TOP = 5;
const FRONT = 50;
/** @type {Found} */
export const NOTHING_FOUND = { best: null, idle: null, pareto: [], ranked: null };

/**
 * @param {Session} session
 * @param {(found: Found) => void} onFound
 */
export function designs(session, onFound) {
  const { selection, record } = session;
  const band = selection.varied.includes(FREQUENCY);
  const { kept, shown } = session;
  const usual = band ? "peak" : "resonance";
  const objectives = /** @type {[string, string][]} */ (Object.entries(session.words.objectives))
    .filter(([name]) => band || name === "resonance")
    .map(
      ([name, text]) =>
        /** @type {[string, string]} */ ([
          name,
          shown.has(VALUE)
            ? text
                .replace("amplitude ratio", "amplitude")
                .replace("r = 1", `f = ${shown.value(FREQUENCY, 1)}`)
            : text,
        ]),
    );
  const respects = /** @type {[string, string][]} */ (Object.entries(session.words.respects))
    .filter(([name]) => name !== "amplitude" && useful(name, session))
    .map(([name, text]) => /** @type {[string, string]} */ ([name, respectIn(shown, name, text)]));
  const asked = {
    objective: kept.one(
      "objective",
      objectives.map(([name]) => name),
      usual,
    ),
    exclude_locked: kept.on("exclude_locked", false),
    against: kept.one(
      "pareto",
      respects.map(([name]) => name),
      "",
    ),
  };
  const table = el("div");
  const front = el("div");
  const judged = () => ({ objective: asked.objective, exclude_locked: asked.exclude_locked });
  let found = NOTHING_FOUND;
  let number = 0;

  async function look() {
    const mine = ++number;
    const question = judged();
    try {
      const path = studyPath(record.id, "optimal-designs");
      const ranked = await ask(path, { ...question, top: TOP });
      const pareto = asked.against
        ? await ask(path, { ...question, top: FRONT, pareto: `amplitude,${asked.against}` })
        : null;
      if (mine !== number) return;
      const { best, idle } = leading(ranked);
      found = {
        best: best && named(best, idle ? "Best with impacts" : "Optimum", shown),
        idle: idle && named(idle, "Best, no impact", shown),
        pareto: (pareto?.designs ?? []).map((d) => named(d, "Pareto front", shown)),
        ranked,
      };
      fill(table, listed(ranked, "Best designs"));
      fill(front, pareto && listed(pareto, "Pareto front", asked.against));
    } catch (error) {
      if (mine !== number) return;
      fill(table, refusalBox(error));
      fill(front);
      found = NOTHING_FOUND;
    }
    if (found.best) selection.rest(found.best);
    onFound(found);
  }

  /** @param {Ranking} answer @param {string} title @param {string} [against] */
  function listed(answer, title, against) {
    const columns = selection.varied.filter((name) => name !== FREQUENCY);
    // what is a column already is not shown twice
    const respect = columns.some((name) => against && name.startsWith(against)) ? undefined : against;
    const heads = columns.map((name) =>
      el(
        "span",
        { title: shown.title(name) },
        shown.symbol(name),
        shown.has(name) && ` [${shown.unit(name).trim()}]`,
      ),
    );
    const reached = (/** @type {Ranked} */ design) =>
      respect === "impact_speed"
        ? shown.value("impact_speed_max", design[respect])
        : short(design[respect ?? ""]);
    const show = (/** @type {Ranked} */ design, /** @type {number} */ i) =>
      el(
        "button",
        {
          type: "button",
          class: "small",
          "aria-label": `Show design ${i + 1} of ${title} on the map`,
          onclick: () => go(design),
        },
        "Show",
      );
    return [
      el("h3", {}, title),
      grid(
        title,
        [
          shown.has(VALUE) ? `Value [${shown.unit(VALUE).trim()}]` : "Value",
          ...heads,
          ...(respect ? [respectIn(shown, respect, session.words.respects[respect])] : []),
          "Response",
          "On the map",
        ],
        answer.designs.map((design, i) => [
          shown.withError(VALUE, design.value, design.error),
          ...columns.map((name) => short(design[name] * shown.factor(name))),
          ...(respect ? [reached(design)] : []),
          design.response_class.replaceAll("_", " "),
          show(design, i),
        ]),
        false,
      ),
      shown.words(answer).verdict.map((sentence) => el("p", {}, prose(sentence))),
      el(
        "details",
        {},
        el("summary", {}, "How they were judged"),
        el("p", { class: "quiet note" }, prose(shown.words(answer).note)),
      ),
    ];
  }

  /** @param {Ranked} design */
  function go(design) {
    selection.chooseValues(
      Object.fromEntries(
        selection.varied.filter((name) => name !== FREQUENCY).map((name) => [name, design[name]]),
      ),
    );
  }

  /** @param {unknown} what */
  function change(what) {
    Object.assign(asked, what);
    kept.keep({
      objective: asked.objective === usual ? null : asked.objective,
      exclude_locked: asked.exclude_locked || null,
      pareto: asked.against,
    });
    look();
  }

  look();
  session.changes.addEventListener("grown", () => table.isConnected && look());
  return el(
    "section",
    { class: "box designs" },
    help("how-to/best-design/", "finding the best design"),
    el("h2", {}, "Designs"),
    el(
      "div",
      { class: "row controls" },
      picker("Judged by", objectives, asked.objective, (objective) => change({ objective })),
      picker("Pareto front against", [["", "nothing"], ...respects], asked.against, (against) =>
        change({ against }),
      ),
      checkbox("Leave out locked designs", asked.exclude_locked, (on) => change({ exclude_locked: on })),
    ),
    table,
    front,
    refinePanel(session, judged),
  );
}

/**
 * Whether designs of a study can differ in a respect.
 *
 * @param {string} respect
 * @param {Session} session
 */
function useful(respect, session) {
  const { varied } = session.selection;
  if (respect === "mass") return varied.includes("mass_ratio");
  if (respect === "clearance") return varied.includes("clearance_ratio");
  return session.variables.includes(respect === "impact_speed" ? "impact_speed_max" : respect);
}

/**
 * What a respect is called, without the ratio where it is shown in units.
 *
 * @param {Shown} shown
 * @param {string} respect
 * @param {string} text
 */
function respectIn(shown, respect, text) {
  const ratio = { mass: "mass_ratio", clearance: "clearance_ratio" }[respect];
  if (ratio && shown.has(ratio)) return shown.title(ratio);
  return respect === "impact_speed" && shown.has("impact_speed_max")
    ? text.replace(", over Z·ω_n", `, in${shown.unit("impact_speed_max")}`)
    : text;
}

/** @param {Ranked} design @param {string} title @param {Shown} shown */
function named(design, title, shown) {
  return Object.assign({ text: `${title}: ${shown.value(VALUE, design.value)}` }, design);
}
