/** A ground-motion suite: one measure over two dimensions, under the worst or one of its records, and the dampers with the least worst case. */

import { ask, refusalBox, studyPath } from "./api.js";
import { el, fill, picker, prose } from "./dom.js";
import { figure } from "./figure.js";
import { help } from "./help.js";
import { lineLayout, lineTraces, mapLayout, mapTraces } from "./map_figure.js";
import { short } from "./numbers.js";
import { RECORD } from "./selection.js";
import { sliders } from "./sliders.js";
import { NAMES, titled } from "./vocabulary.js";
import { WORDS } from "./words.js";

const MOST = 240;
const TOP = 10;
const USUAL = WORDS.suite_axes;

/** @type {import("./study.js").Tab} */
export function suiteTab(session, place) {
  const { selection, record, words } = session;
  const { variables } = words.suite;
  const [x, y] = [...USUAL.filter((name) => selection.axes[name].length > 1), ...USUAL.filter((name) => selection.axes[name].length === 1)];
  const view = { x, y, metric: session.variables[0], record: "" };
  const chart = figure({ label: `Map of ${record.name || record.id}`, name: `map-${record.id}`, height: 460 });
  const note = el("p", { class: "quiet note" });
  const trouble = el("div");
  const controls = el("div", { class: "row controls" });
  const table = el("div");
  let asked = 0;

  function drawControls() {
    const names = /** @type {[string, string][]} */ (USUAL.map((name) => [name, titled(name)]));
    const metrics = variables.filter((/** @type {any} */ one) => session.variables.includes(one.name));
    const records = selection.axes[RECORD].map((id) => [id, id]);
    fill(
      controls,
      picker("Across", names, view.x, (name) => exchange("x", "y", name)),
      picker("Up", names, view.y, (name) => exchange("y", "x", name)),
      picker("Shown", metrics.map((/** @type {any} */ one) => [one.name, unitOf(one)]), view.metric, (metric) => change({ metric })),
      picker("Record", /** @type {[string, string][]} */ ([["", "the worst of all"], ...records]), view.record, (id) => change({ record: id })),
    );
  }

  /** @param {"x" | "y"} mine @param {"x" | "y"} other @param {string} name */
  function exchange(mine, other, name) {
    if (view[other] === name) view[other] = view[mine];
    view[mine] = name;
    drawControls();
    look();
  }

  /** @param {any} what */
  function change(what) {
    Object.assign(view, what);
    look();
    rank();
  }

  async function look() {
    const mine = ++asked;
    try {
      const answer = await ask(studyPath(record.id, "resonance-map"), { ...view, most: MOST, ...selection.at([view.x, view.y, RECORD]) });
      if (mine !== asked) return;
      fill(trouble);
      fill(note, prose(said(answer)));
      if (answer.y.length === 1) await chart.draw(() => lineTraces(answer), () => lineLayout(answer));
      else await chart.draw(() => mapTraces(answer, { contours: true, classes: false }, { best: null, idle: null, pareto: [], point: null }, words), () => mapLayout(answer));
    } catch (error) {
      if (mine === asked) fill(trouble, refusalBox(error));
    }
  }

  async function rank() {
    if (variables.find((/** @type {any} */ one) => one.name === view.metric).coded) return fill(table);
    try {
      const ranked = await ask(studyPath(record.id, "optimal-designs"), { metric: view.metric, record: view.record, top: TOP });
      fill(table, ranking(ranked));
    } catch (error) {
      fill(table, refusalBox(error));
    }
  }

  /** @param {any} ranked */
  function ranking(ranked) {
    const columns = WORDS.damper.filter((name) => selection.axes[name].length > 1);
    const cells = (/** @type {any} */ one) => [...columns.map((name) => short(one[name])), short(one.value), one.record, short(one.scale), ...("growth" in one ? [short(one.growth, 3)] : [])];
    const heads = [...columns.map((name) => NAMES[name]), "Worst case", "under", "times", ...("growth" in ranked.columns ? ["Growth of a perturbation"] : [])];
    return [
      el(
        "div",
        { class: "scroll", tabindex: 0, role: "region", "aria-label": "Best dampers" },
        el(
          "table",
          {},
          el("thead", {}, el("tr", {}, heads.map((head) => el("th", { scope: "col" }, head)))),
          el("tbody", {}, ranked.designs.map((/** @type {any} */ one) => el("tr", {}, cells(one).map((text) => el("td", {}, text))))),
        ),
      ),
      el("p", { class: "quiet note" }, prose(ranked.note)),
    ];
  }

  selection.addEventListener("chosen", look);
  session.changes.addEventListener("grown", () => place.isConnected && (look(), rank()));
  drawControls();
  fill(
    place,
    el(
      "div",
      { class: "study" },
      el("div", { class: "left" }, controls, trouble, chart.element, note, sliders(selection, session.shown)),
      el("section", { class: "box designs" }, help("how-to/earthquakes/", "ground-motion suites"), el("h2", {}, "Best dampers"), table),
    ),
  );
  look();
  rank();
}

/** @param {{long_name: string, units: string}} variable */
function unitOf({ long_name, units }) {
  return units === "1" ? long_name : `${long_name} [${units}]`;
}

/** @param {any} answer */
function said(answer) {
  const share = answer.complete < 1 ? `${Math.floor(100 * answer.complete)} % of this map is computed. ` : "";
  const failed = answer.points_failed ? `${answer.points_failed} points failed. ` : "";
  return share + failed + answer.note;
}
