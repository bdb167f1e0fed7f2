/** Shows a map of the worst cases of dampers over two dimensions, and a table of the best dampers. */
/** @import { MapAnswer, Ranked, Ranking, Session, Tab } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { el, fill, grid, picker, prose } from "./dom.js";
import { Figure } from "./figure.js";
import { isBeaten } from "./headline.js";
import { help } from "./help.js";
import { MapAxes, said } from "./map_axes.js";
import { drawMap, mapTraces } from "./map_figure.js";
import { measures, unitOf } from "./measures.js";
import { short } from "./numbers.js";
import { pythonLine } from "./python_line.js";
import { AMPLITUDE, FREQUENCY, RECORD } from "./selection.js";
import { SurveyMotion } from "./survey_motion.js";
import { SurveyPoint } from "./survey_point.js";
import { inBrackets } from "./shown.js";
import { sliders } from "./sliders.js";
import { WORDS } from "./words.js";

const MOST = 240;
const TOP = 10;

/**
 * Texts for suites and, below, for studies over base amplitudes. `met` names the dimension that no designer
 * chooses.
 */
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
  new DampersTab(session, place);
}

class DampersTab {
  /** @type {Record<string, unknown>} the last request for the map */
  question = {};
  note = el("p", { class: "quiet note" });
  trouble = el("div");
  controls = el("div", { class: "row controls" });
  table = el("div");
  asked = 0;
  ranks = 0;

  /** @param {Session} session @param {HTMLElement} place */
  constructor(session, place) {
    this.session = session;
    const { selection, record, kept, changes } = session;
    const suite = RECORD in selection.axes;
    this.kind = suite ? SUITE : AMPLITUDES;
    const { axes, met } = this.kind;
    const several = (/** @type {string} */ name) => selection.axes[name].length > 1;
    const order = [...axes.filter(several), ...axes.filter((name) => !several(name))];
    this.axes = new MapAxes(session, order, axes);
    this.variables = measures(session).filter(({ name }) => session.variables.includes(name));
    this.usual = suite ? session.variables[0] : this.variables[0].name;
    this.view = {
      metric: kept.one(
        "metric",
        this.variables.map((one) => one.name),
        this.usual,
      ),
      met: kept.one("case", selection.axes[met].map(String), ""),
    };
    this.keptMetric = this.view.metric;
    this.chart = new Figure({
      label: `Map of ${record.name || record.id}`,
      name: `map-${record.id}`,
      height: 460,
      python: () => pythonLine(record.id, "resonance_map", this.question),
      clicked: (point) => this.axes.choose(point, selection.axes[this.axes.y].length),
    });
    this.point = suite ? new SurveyPoint(session, this.view, this.variables) : null;
    this.motion = suite ? new SurveyMotion(session) : null;
    selection.addEventListener("chosen", () => this.look());
    changes.addEventListener("grown", () => place.isConnected && (this.look(), this.rank(true)));
    this.drawControls();
    this.drawIn(place);
    this.look();
    this.rank();
    this.point?.look();
    this.motion?.look();
  }

  /** @param {HTMLElement} place */
  drawIn(place) {
    const { controls, trouble, chart, note, point, motion, table, kind } = this;
    const { selection, shown } = this.session;
    const left = [controls, trouble, chart.element, note, sliders(selection, shown), point?.element];
    const best = el(
      "section",
      { class: "box designs" },
      help(kind.page, kind.about),
      el("h2", {}, "Best dampers"),
      table,
    );
    fill(
      place,
      el(
        "div",
        { class: "study" },
        el("div", { class: "left" }, left),
        el("div", { class: "beside" }, best, motion?.element),
      ),
    );
  }

  drawControls() {
    const { kind, view, variables } = this;
    const { selection, shown } = this.session;
    const met = selection.axes[kind.met].map((value) => [
      String(value),
      kind === SUITE ? String(value) : shown.value(AMPLITUDE, value),
    ]);
    fill(
      this.controls,
      this.axes.pickers(kind.axes, () => (this.drawControls(), this.keep(), this.look())),
      picker(
        "Shown",
        variables.map((one) => [one.name, unitOf(one)]),
        view.metric,
        (metric) => this.change({ metric }),
      ),
      picker(
        kind.label,
        /** @type {[string, string][]} */ ([["", "the worst of all"], ...met]),
        view.met,
        (one) => this.change({ met: one }),
      ),
    );
  }

  /** Store in the address the choices that differ from the default view. */
  keep() {
    const { metric, met } = this.view;
    // a limit applies to one metric, so the choice of another metric removes the limit
    const limit = metric === this.keptMetric ? {} : { limit: null };
    this.keptMetric = metric;
    const { kept } = this.session;
    kept.keep({ ...this.axes.kept, metric: metric === this.usual ? null : metric, case: met, ...limit });
  }

  /** @param {Partial<{metric: string, met: string}>} what */
  change(what) {
    Object.assign(this.view, what);
    this.keep();
    this.look();
    this.rank();
    this.point?.look();
  }

  /** The parameters of the request for the map; empty parameters are left out. */
  whole() {
    const { selection } = this.session;
    const { x, y } = this.axes;
    const { metric, met } = this.view;
    const fixed = met === "" || [x, y].includes(this.kind.met) ? {} : { [this.kind.met]: met };
    const open = [x, y, this.kind.met, ...(selection.worst ? [FREQUENCY] : [])];
    return { x, y, metric, ...fixed, ...selection.at(open) };
  }

  async look() {
    const mine = ++this.asked;
    const { record, shown, words } = this.session;
    try {
      const whole = this.whole();
      const given = await ask(studyPath(record.id, "resonance-map"), { ...whole, most: MOST });
      if (mine !== this.asked) return;
      this.question = whole;
      const map = shown.map({ ...given, long_name: given.long_name + inBrackets(given.units) });
      fill(this.trouble);
      fill(this.note, prose(said(given, shown)));
      const overlays = { contours: true, classes: false };
      await drawMap(this.chart, map, () => mapTraces(map, overlays, this.marks(map), words));
    } catch (error) {
      if (mine === this.asked) fill(this.trouble, refusalBox(error));
    }
  }

  /** The metric that is shown. */
  get variable() {
    return this.variables.find((one) => one.name === this.view.metric);
  }

  /** The markers of the point and, on a map of dampers, of the smallest value. @param {MapAnswer} map */
  marks(map) {
    const { x, y, point } = this.axes;
    const judged =
      [x, y].every((name) => this.kind.damper.includes(name)) && WORDS.judged.includes(this.view.metric);
    const best = judged ? leastOf(map) : null;
    const look = { acts: false, name: "least on this map" };
    return {
      best: best && { x: best.x, y: best.y, text: `least: ${short(best.value)}`, ...look },
      other: null,
      pareto: [],
      point,
    };
  }

  /** Rank the dampers, and select the best damper if the user has chosen none. @param {boolean} [grown] */
  async rank(grown) {
    const mine = ++this.ranks;
    const { record, selection } = this.session;
    const { metric } = this.view;
    if (this.variable?.coded) return fill(this.table);
    try {
      const path = studyPath(record.id, "optimal-designs");
      const ranked = await ask(path, { metric, ...this.only(), top: TOP });
      if (mine !== this.ranks) return;
      fill(this.table, this.ranking(ranked));
      if (grown && ranked.designs.length) selection.rest(ranked.designs[0]);
    } catch (error) {
      if (mine === this.ranks) fill(this.table, refusalBox(error));
    }
  }

  /** @param {Ranking} ranked */
  ranking(ranked) {
    const { selection, shown } = this.session;
    const columns = this.kind.damper.filter((name) => selection.axes[name].length > 1);
    const where =
      this.kind === SUITE ? ["under", "times"] : ["at base amplitude", "and frequency", "Response there"];
    const heads = [
      ...columns.map((name) => shown.title(name)),
      `Worst case${inBrackets(ranked.units)}`,
      ...where,
      ...("growth" in ranked.columns ? ["Growth of a perturbation"] : []),
    ];
    const rows = ranked.designs.map((one) => [
      ...columns.map((name) => short(one[name] * shown.factor(name))),
      short(one.value * shown.factor(this.view.metric)),
      ...this.where(one),
      ...("growth" in one ? [short(one.growth, 3)] : []),
    ]);
    return [
      isBeaten(ranked) && el("p", {}, prose(shown.words(ranked).verdict.join(" "))),
      grid("Best dampers", heads, rows, false),
      el("p", { class: "quiet note" }, prose(ranked.note ?? "")),
    ];
  }

  /** The record and scale, or the amplitude, of a damper's worst case. @param {Ranked} one */
  where(one) {
    const { shown } = this.session;
    if (this.kind === SUITE) return [one.record, short(one.scale)];
    return [
      shown.value(AMPLITUDE, one[AMPLITUDE]),
      shown.value(FREQUENCY, one[FREQUENCY]),
      one.response_class?.replaceAll("_", " ") ?? "–",
    ];
  }

  /** Parameters that restrict the ranking to the chosen case, if any. @returns {Record<string, string>} */
  only() {
    const { met } = this.view;
    if (!met) return {};
    return { [this.kind.met]: this.kind === SUITE ? met : `${met},${met}` };
  }
}

/** The smallest value of a map with its coordinates; null if no value is known. @param {MapAnswer} map */
function leastOf({ x, y, values }) {
  const known = values.flatMap((row, j) =>
    row.flatMap((value, i) => (value === null ? [] : [{ x: x[i], y: y[j], value }])),
  );
  return known.reduce(
    (least, one) => (least === null || one.value < least.value ? one : least),
    /** @type {{x: number, y: number, value: number} | null} */ (null),
  );
}
