/**
 * Dampers judged by their worst case, over the records of a suite or over base amplitudes: a measure over two
 * dimensions, and the best of them.
 */
/** @import { MapAnswer, Ranked, Ranking, Tab } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { axisPickers } from "./axis_pickers.js";
import { el, fill, grid, picker, prose } from "./dom.js";
import { figure } from "./figure.js";
import { help } from "./help.js";
import { lineLayout, lineTraces, mapLayout, mapTraces } from "./map_figure.js";
import { measures, unitOf } from "./measures.js";
import { short } from "./numbers.js";
import { pythonLine } from "./python_line.js";
import { AMPLITUDE, FREQUENCY, RECORD } from "./selection.js";
import { surveyMotion } from "./survey_motion.js";
import { surveyPoint } from "./survey_point.js";
import { inBrackets } from "./shown.js";
import { sliders } from "./sliders.js";
import { WORDS } from "./words.js";

const MOST = 240;
const TOP = 10;

/** What is met by a damper of a suite, and of a study over base amplitudes. */
const SUITE = {
  axes: WORDS.suite_axes,
  damper: WORDS.damper,
  met: RECORD,
  label: "Record",
  page: "how-to/earthquakes/",
  about: "ground-motion suites",
};
const AMPLITUDES = {
  axes: WORDS.amplitude_axes,
  damper: WORDS.amplitude_damper,
  met: AMPLITUDE,
  label: "Base amplitude",
  page: "how-to/base-amplitudes/",
  about: "studies over base amplitudes",
};

/** @type {Tab} */
export function dampersTab(session, place) {
  const { selection, record, words, shown, kept } = session;
  const kind = RECORD in selection.axes ? SUITE : AMPLITUDES;
  const variables = measures(session);
  const [x, y] = [
    ...kind.axes.filter((name) => selection.axes[name].length > 1),
    ...kind.axes.filter((name) => selection.axes[name].length === 1),
  ];
  const usual = { x, y, metric: kind === SUITE ? session.variables[0] : variables[0].name, met: "" };
  const view = {
    x: kept.one("x", kind.axes, x),
    y: kept.one("y", kind.axes, y),
    metric: kept.one(
      "metric",
      variables.map((one) => one.name).filter((name) => session.variables.includes(name)),
      usual.metric,
    ),
    met: kept.one("case", selection.axes[kind.met].map(String), ""),
  };
  if (view.x === view.y) Object.assign(view, { x, y });
  /** @type {Record<string, unknown>} what the map was asked for last */
  let question = {};
  const chart = figure({
    label: `Map of ${record.name || record.id}`,
    name: `map-${record.id}`,
    height: 460,
    python: () => pythonLine(record.id, "resonance_map", question),
    clicked: (at) => {
      const [atX, atY] = [at.x / shown.factor(view.x), at.y / shown.factor(view.y)];
      const several = selection.axes[view.y].length > 1;
      selection.chooseValues({ [view.x]: atX, ...(several ? { [view.y]: atY } : {}) });
    },
  });
  const note = el("p", { class: "quiet note" });
  const trouble = el("div");
  const controls = el("div", { class: "row controls" });
  const table = el("div");
  const point = kind === SUITE ? surveyPoint(session, view, variables) : null;
  const motion = kind === SUITE ? surveyMotion(session) : null;
  let asked = 0;
  let ranks = 0;
  let keptMetric = view.metric;

  function drawControls() {
    const names = /** @type {[string, string][]} */ (kind.axes.map((name) => [name, shown.title(name)]));
    const metrics = variables.filter((one) => session.variables.includes(one.name));
    const met = selection.axes[kind.met].map((value) => [
      String(value),
      kind === SUITE ? String(value) : shown.value(AMPLITUDE, value),
    ]);
    fill(
      controls,
      axisPickers(names, view, () => (drawControls(), keep(), look())),
      picker(
        "Shown",
        metrics.map((one) => [one.name, unitOf(one)]),
        view.metric,
        (metric) => change({ metric }),
      ),
      picker(
        kind.label,
        /** @type {[string, string][]} */ ([["", "the worst of all"], ...met]),
        view.met,
        (one) => change({ met: one }),
      ),
    );
  }

  /** Keep what differs from the usual view in the address. */
  function keep() {
    const axes = view.x === usual.x && view.y === usual.y ? { x: null, y: null } : { x: view.x, y: view.y };
    // a limit is one of a metric
    const limit = view.metric === keptMetric ? {} : { limit: null };
    keptMetric = view.metric;
    kept.keep({
      ...axes,
      metric: view.metric === usual.metric ? null : view.metric,
      case: view.met,
      ...limit,
    });
  }

  /** @param {unknown} what */
  function change(what) {
    Object.assign(view, what);
    keep();
    look();
    rank();
    point?.look();
  }

  async function look() {
    const mine = ++asked;
    try {
      const { met, ...plane } = view;
      const fixed = [view.x, view.y].includes(kind.met) ? {} : { [kind.met]: met };
      const open = [view.x, view.y, kind.met, ...(selection.worst ? [FREQUENCY] : [])];
      const whole = Object.fromEntries(
        Object.entries({ ...plane, ...fixed, ...selection.at(open) }).filter(([, value]) => value !== ""),
      );
      const given = await ask(studyPath(record.id, "resonance-map"), { ...whole, most: MOST });
      if (mine !== asked) return;
      question = whole;
      const answer = shown.map({ ...given, long_name: given.long_name + inBrackets(given.units) });
      fill(trouble);
      fill(note, prose(said(answer, shown.words(given).note)));
      if (answer.y.length === 1)
        await chart.draw(
          () => lineTraces(answer),
          () => lineLayout(answer),
        );
      else
        await chart.draw(
          () => mapTraces(answer, { contours: true, classes: false }, marks(answer), words),
          () => mapLayout(answer),
        );
    } catch (error) {
      if (mine === asked) fill(trouble, refusalBox(error));
    }
  }

  /**
   * The smallest value, where a designer chooses both dimensions, and the point.
   *
   * @param {MapAnswer} answer
   */
  function marks(answer) {
    const chosen = {
      x: selection.value(view.x) * shown.factor(view.x),
      y: selection.value(view.y) * shown.factor(view.y),
    };
    const judged =
      [view.x, view.y].every((name) => kind.damper.includes(name)) &&
      /^(peak|rms|amplitude|relative_amplitude)_(?!error)/.test(view.metric);
    /** @type {{x: number, y: number, value: number} | null} */
    let least = null;
    answer.values.forEach((row, j) =>
      row.forEach((value, i) => {
        if (judged && value !== null && (least === null || value < least.value))
          least = { x: answer.x[i], y: answer.y[j], value };
      }),
    );
    const best = /** @type {{x: number, y: number, value: number} | null} */ (least);
    return {
      best: best && {
        x: best.x,
        y: best.y,
        text: `least: ${short(best.value)}`,
        acts: false,
        name: "least on this map",
      },
      idle: null,
      pareto: [],
      point: chosen,
    };
  }

  /**
   * Rank the dampers; a study that has grown leads to the best of them, unless somebody has chosen one.
   *
   * @param {boolean} [grown]
   */
  async function rank(grown) {
    const mine = ++ranks;
    if (variables.find((one) => one.name === view.metric)?.coded) return fill(table);
    try {
      const ranked = await ask(studyPath(record.id, "optimal-designs"), {
        metric: view.metric,
        ...only(),
        top: TOP,
      });
      if (mine !== ranks) return;
      fill(table, ranking(ranked));
      if (grown && ranked.designs.length) selection.rest(ranked.designs[0]);
    } catch (error) {
      if (mine === ranks) fill(table, refusalBox(error));
    }
  }

  /** @param {Ranking} ranked */
  function ranking(ranked) {
    const columns = kind.damper.filter((name) => selection.axes[name].length > 1);
    const suite = kind === SUITE;
    const where = (/** @type {Ranked} */ one) =>
      suite
        ? [one.record, short(one.scale)]
        : [
            shown.value(AMPLITUDE, one[AMPLITUDE]),
            shown.value(FREQUENCY, one[FREQUENCY]),
            words.response_class[codeOf(one.response_class)]?.name ?? "–",
          ];
    const cells = (/** @type {Ranked} */ one) => [
      ...columns.map((name) => short(one[name] * shown.factor(name))),
      short(one.value * shown.factor(view.metric)),
      ...where(one),
      ...("growth" in one ? [short(one.growth, 3)] : []),
    ];
    const heads = [
      ...columns.map((name) => shown.title(name)),
      `Worst case${inBrackets(ranked.units)}`,
      ...(suite ? ["under", "times"] : ["at base amplitude", "and frequency", "Response there"]),
      ...("growth" in ranked.columns ? ["Growth of a perturbation"] : []),
    ];
    return [
      grid("Best dampers", heads, ranked.designs.map(cells), false),
      el("p", { class: "quiet note" }, prose(ranked.note ?? "")),
    ];
  }

  /** The one case that counts, where one is chosen. @returns {Record<string, string>} */
  function only() {
    if (!view.met) return {};
    return { [kind.met]: kind === SUITE ? view.met : `${view.met},${view.met}` };
  }

  /** @param {string} name */
  function codeOf(name) {
    return (
      Object.keys(words.response_class).find(
        (code) => words.response_class[code].name === name?.replaceAll("_", " "),
      ) ?? ""
    );
  }

  selection.addEventListener("chosen", look);
  session.changes.addEventListener("grown", () => place.isConnected && (look(), rank(true)));
  drawControls();
  fill(
    place,
    el(
      "div",
      { class: "study" },
      el(
        "div",
        { class: "left" },
        controls,
        trouble,
        chart.element,
        note,
        sliders(selection, session.shown),
        point?.element,
      ),
      el(
        "div",
        { class: "beside" },
        el(
          "section",
          { class: "box designs" },
          help(kind.page, kind.about),
          el("h2", {}, "Best dampers"),
          table,
        ),
        motion?.element,
      ),
    ),
  );
  look();
  rank();
  point?.look();
  motion?.look();
}

/** @param {MapAnswer} answer @param {string} note */
function said(answer, note) {
  const share = answer.complete < 1 ? `${Math.floor(100 * answer.complete)} % of this map is computed. ` : "";
  const failed = answer.points_failed ? `${answer.points_failed} points failed. ` : "";
  return share + failed + note;
}
