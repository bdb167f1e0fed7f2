/** The map of a study with its controls, and the selected point. */
/** @import { Found, Kept, MapAnswer, Marked, Session, Tab } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { DesignsPanel, NOTHING_FOUND } from "./designs.js";
import { checkbox, el, fill, picker, prose } from "./dom.js";
import { Figure } from "./figure.js";
import { headline } from "./headline.js";
import { MapAxes, said } from "./map_axes.js";
import { drawMap, mapTraces } from "./map_figure.js";
import { PointPanel } from "./point.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { sliders } from "./sliders.js";
import { DIMENSIONS } from "./vocabulary.js";
import { WORDS } from "./words.js";

/** Largest number of values requested along each axis, about as many as a screen can show. */
const MOST = 240;
const PATIENCE_MILLISECONDS = 1500;
const USUAL_METRIC = "amplitude_ratio";

/** @type {Tab} */
export function mapTab(session, place) {
  new MapTab(session, place);
}

class MapTab {
  /** @type {MapAnswer | null} */
  map = null;
  found = NOTHING_FOUND;
  asked = 0;
  /** The last request, as text. */
  last = "";
  note = el("p", { class: "quiet note" });
  trouble = el("div");
  head = el("div");
  controls = el("div", { class: "row controls" });

  /** @param {Session} session @param {HTMLElement} place */
  constructor(session, place) {
    this.session = session;
    const { selection, record, kept, variables } = session;
    this.axes = new MapAxes(session, usualAxes(selection.varied), selection.varied);
    this.view = keptLook(kept, variables);
    this.chart = new Figure({
      label: `Resonance map of ${record.name || record.id}`,
      name: `map-${record.id}`,
      height: 460,
      keyboard: "Arrow keys move the point",
      python: () => pythonLine(record.id, "resonance_map", this.whole()),
      clicked: (point) => this.axes.choose(point, this.map?.y.length),
      zoomed: (change) => this.zoomed(change),
    });
    this.drawControls();
    const ranking = new DesignsPanel(session, (found) => this.judged(found));
    this.drawIn(place, ranking.element);
    this.listen(place);
    this.look();
  }

  /** @param {HTMLElement} place @param {HTMLElement} ranking */
  drawIn(place, ranking) {
    const { head, controls, trouble, chart, note } = this;
    const { selection, shown } = this.session;
    const parts = [head, controls, trouble, chart.element, note, sliders(selection, shown)];
    fill(
      place,
      el(
        "div",
        { class: "study" },
        el("div", { class: "left" }, parts),
        new PointPanel(this.session, () => this.found.best).element,
        ranking,
      ),
    );
  }

  /** @param {HTMLElement} place */
  listen(place) {
    const { selection, changes } = this.session;
    this.chart.plot.addEventListener("keydown", (event) => this.moved(event));
    selection.addEventListener("chosen", () =>
      JSON.stringify(this.question()) === this.last ? this.draw() : this.look(),
    );
    const look = throttled(PATIENCE_MILLISECONDS, () => place.isConnected && this.look());
    changes.addEventListener("grown", look);
  }

  /** @param {Found} found */
  judged(found) {
    this.found = found;
    fill(this.head, found.ranked && headline(this.session, found.ranked));
    this.draw();
  }

  drawControls() {
    const { selection, words, variables, shown } = this.session;
    const { x, y } = this.axes.usual;
    const { view } = this;
    const choices =
      selection.varied.length > 1 ? selection.varied : DIMENSIONS.filter((name) => name === x || name === y);
    const metrics = words.variables.filter(({ name }) => variables.includes(name));
    const overlay = (/** @type {string} */ label, /** @type {"contours" | "classes"} */ name) =>
      checkbox(label, view[name], (on) => ((view[name] = on), this.keep(), this.draw()));
    fill(
      this.controls,
      this.axes.pickers(choices, () => (this.drawControls(), this.change({ window: {} }))),
      picker(
        "Shown",
        metrics.map(({ name, long_name }) => [name, shown.variable(name, long_name)]),
        view.metric,
        (metric) => this.change({ metric }),
      ),
      overlay("Contour lines", "contours"),
      overlay("Response classes", "classes"),
    );
  }

  /** @param {Partial<ReturnType<typeof keptLook>>} what */
  change(what) {
    Object.assign(this.view, what);
    this.keep();
    this.look();
  }

  /** Store in the address the choices that differ from the default view. */
  keep() {
    const { metric, contours, classes, window } = this.view;
    this.session.kept.keep({
      ...this.axes.kept,
      metric: metric === USUAL_METRIC ? null : metric,
      contours: contours ? null : false,
      classes: classes || null,
      x_range: window.x_range,
      y_range: window.y_range,
    });
  }

  /** The request for the map at the point; without a frequency, the map shows the worst case. */
  whole() {
    const { selection } = this.session;
    const { x, y } = this.axes;
    const except = [x, y, ...(selection.worst ? [FREQUENCY] : [])];
    return { x, y, metric: this.view.metric, ...selection.at(except) };
  }

  /** The request for the map, limited to the zoomed range and to the resolution of a screen. */
  question() {
    return { ...this.whole(), most: MOST, ...this.view.window };
  }

  async look() {
    const mine = ++this.asked;
    const parameters = this.question();
    const { record, shown } = this.session;
    this.last = JSON.stringify(parameters);
    try {
      const answer = await ask(studyPath(record.id, "resonance-map"), parameters);
      if (mine !== this.asked) return;
      this.map = shown.map(answer);
      fill(this.trouble);
      fill(this.note, prose(said(answer, shown)));
      await this.draw();
    } catch (error) {
      if (mine === this.asked) fill(this.trouble, refusalBox(error));
    }
  }

  async draw() {
    const { map, view } = this;
    if (!map) return;
    await drawMap(this.chart, map, () => mapTraces(map, view, this.marks(), this.session.words));
  }

  /** The marks of the designs that lie in this map, and of the point. */
  marks() {
    const { selection, shown } = this.session;
    const { x, y } = this.axes;
    const { best, other, pareto } = this.found;
    const judged = x !== FREQUENCY && y !== FREQUENCY;
    const here = (/** @type {Marked | null} */ design) =>
      judged &&
      design &&
      selection.varied.every(
        (name) => [x, y, FREQUENCY].includes(name) || design[name] === selection.value(name),
      );
    const mark = (/** @type {Marked} */ design) => ({
      x: design[x] * shown.factor(x),
      y: design[y] * shown.factor(y),
      text: design.text,
    });
    return {
      best: best && here(best) ? { ...mark(best), acts: other !== null && best.impact_share > 0 } : null,
      other: other && here(other) ? { ...mark(other), acts: other.impact_share > 0 } : null,
      pareto: pareto.filter(here).map(mark),
      point: selection.chosen ? this.axes.point : null,
    };
  }

  /**
   * Keep a zoomed range in the address, and request the map again, which then has more points in this range.
   *
   * @param {Record<string, unknown>} event
   */
  zoomed(event) {
    if (event["xaxis.autorange"] && this.view.window.x_range) return this.change({ window: {} });
    if (event["xaxis.range[0]"] === undefined && event["yaxis.range[0]"] === undefined) return;
    // the range is kept in ratios, so that the address does not depend on the shown units
    const span = (/** @type {"x" | "y"} */ axis) => {
      const { type, range = [] } = this.chart.plot.layout[`${axis}axis`] ?? {};
      return range
        .map((end) => (type === "log" ? 10 ** end : end) / this.session.shown.factor(this.axes[axis]))
        .sort((a, b) => a - b)
        .join(",");
    };
    this.change({ window: { x_range: span("x"), y_range: span("y") } });
  }

  /** Move the point by the keyboard. @param {KeyboardEvent} event */
  moved(event) {
    const { selection } = this.session;
    const { x, y } = this.axes;
    const steps = /** @type {Record<string, [string, number]>} */ ({
      ArrowLeft: [x, -1],
      ArrowRight: [x, 1],
      ArrowDown: [y, -1],
      ArrowUp: [y, 1],
    });
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    selection.choose({ [step[0]]: selection.place[step[0]] + step[1] });
  }
}

/** The kept choices of a map, besides its dimensions. @param {Kept} kept @param {string[]} variables */
function keptLook(kept, variables) {
  const { x_range, y_range } = kept.values;
  const span = /^[-+.\de]+,[-+.\de]+$/;
  return {
    metric: kept.one("metric", variables, USUAL_METRIC),
    contours: kept.on("contours", true),
    classes: kept.on("classes", false),
    /** @type {Record<string, string | undefined>} */
    window: span.test(x_range) && span.test(y_range) ? { x_range, y_range } : {},
  };
}

/** @param {string[]} varied @returns {[string, string]} */
function usualAxes(varied) {
  const order = WORDS.axes.filter((name) => varied.includes(name));
  const rest = WORDS.axes.filter((name) => !order.includes(name));
  const [x, y] = [...order, ...rest];
  return [x, y];
}

/**
 * Limit the calls of a function to one per interval. The last call is never lost.
 *
 * @param {number} milliseconds
 * @param {() => void} run
 */
function throttled(milliseconds, run) {
  let waiting = false;
  let again = false;
  const go = () => {
    if (waiting) {
      again = true;
      return;
    }
    run();
    waiting = true;
    setTimeout(() => {
      waiting = false;
      if (again) {
        again = false;
        go();
      }
    }, milliseconds);
  };
  return go;
}
