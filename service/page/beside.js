/** Compares two studies: the same map of each study on one colour scale, and the difference of the maps. */
/** @import { MapDifference, Session, StudyRecord, Tab } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { differenceTraces, sharedTraces, sideTraces } from "./beside_figure.js";
import { el, fill, picker, prose, quiet } from "./dom.js";
import { Figure } from "./figure.js";
import { help } from "./help.js";
import { MapAxes } from "./map_axes.js";
import { drawMap } from "./map_figure.js";
import { measures, unitOf } from "./measures.js";
import { pythonLine } from "./python_line.js";
import { AMPLITUDE, FREQUENCY, RECORD } from "./selection.js";
import { sliders } from "./sliders.js";
import { isComparable, orderOf } from "./vocabulary.js";

const MOST = 160;
/** Number of newest studies among which the page looks for comparable studies. */
const OFFERED = 200;
const CHOOSE = "Choose a study with the same axes.";
const NONE =
  "There is no other study of this kind yet. " +
  "Edit a copy of this one, change what you want to compare, and come back.";

/** @type {Tab} */
export function besideTab(session, place) {
  new BesideTab(session, place);
}

class BesideTab {
  /** @type {MapDifference | null} */
  answer = null;
  /** @type {StudyRecord[]} */
  others = [];
  asked = 0;
  controls = el("div", { class: "row controls" });
  trouble = el("div");
  note = el("p", { class: "note", role: "status" });

  /** @param {Session} session @param {HTMLElement} place */
  constructor(session, place) {
    this.session = session;
    const { selection, kept, variables, changes } = session;
    const numeric = Object.keys(selection.axes).filter((name) => name !== RECORD);
    const varied = numeric.filter((name) => selection.axes[name].length > 1);
    const usual = [...orderOf(Object.keys(selection.axes)), ...numeric];
    const order = [...new Set([...usual.filter((name) => varied.includes(name)), ...usual])];
    this.axes = new MapAxes(session, order, varied);
    this.choices = varied.length > 1 ? varied : order.slice(0, 2);
    this.metrics = measures(session).filter((one) => !one.coded && variables.includes(one.name));
    const names = this.metrics.map((one) => one.name);
    this.view = { metric: kept.one("metric", names, names[0]), minus: kept.values.minus ?? "" };
    this.charts = ["this study", "the other study", "this study minus the other"].map((label, i) =>
      this.chart(label, i),
    );
    this.titles = this.charts.map(() => el("h3", {}));
    this.maps = el(
      "div",
      { class: "sides" },
      this.charts.map(({ element }, i) => el("div", {}, this.titles[i], element)),
    );
    selection.addEventListener("chosen", () => place.isConnected && this.look());
    changes.addEventListener("grown", () => place.isConnected && this.look());
    this.drawIn(place);
    void this.offer();
  }

  /** @param {string} label @param {number} i */
  chart(label, i) {
    const { record } = this.session;
    return new Figure({
      label: `Map of ${label}`,
      name: `${["this", "other", "difference"][i]}-${record.id}`,
      height: 340,
      python: () =>
        pythonLine(
          i === 1 ? this.view.minus : record.id,
          "resonance_map",
          i === 2 ? this.question() : { ...this.question(), minus: null },
        ),
      clicked: (point) => this.axes.choose(point, this.answer?.y.length),
    });
  }

  /** @param {HTMLElement} place */
  drawIn(place) {
    const { selection, shown } = this.session;
    fill(
      place,
      el(
        "section",
        { class: "box beside-study" },
        help("page/#compare-with-another-study", "two studies side by side"),
        el("h2", {}, "Compare with another study"),
        quiet(
          "The same map of two studies with the same axes, on one colour scale, and the first minus " +
            "the second: where the difference is below 0, this study has the smaller value.",
        ),
        this.controls,
        this.trouble,
        this.note,
        this.maps,
        sliders(selection, shown),
      ),
    );
  }

  /** Request other studies, and offer the studies that the service can compare with this study. */
  async offer() {
    const { record } = this.session;
    const { view } = this;
    try {
      const { studies } = await ask("studies", { limit: OFFERED });
      this.others = studies.filter((one) => one.id !== record.id);
      const meant = (/** @type {StudyRecord} */ one) =>
        view.minus && (one.id.startsWith(view.minus) || one.name === view.minus);
      view.minus = this.others.find(meant)?.id ?? view.minus;
    } catch (error) {
      fill(this.trouble, refusalBox(error));
    }
    this.drawControls();
    this.look();
  }

  /** The studies with as many values as this study along the axes of the map and the reduced dimensions. */
  get offered() {
    const { record, selection } = this.session;
    const { x, y } = this.axes;
    const along = [x, y, RECORD, AMPLITUDE, ...(selection.worst ? [FREQUENCY] : [])];
    return this.others.filter((one) => isComparable(record, one, along));
  }

  drawControls() {
    const { view, metrics } = this;
    const { shown } = this.session;
    const offered = this.offered.map((one) => [one.id, `${one.name || "(no name)"} · ${one.id}`]);
    const known = !view.minus || this.offered.some((one) => one.id === view.minus);
    const options = [["", "choose a study"], ...(known ? [] : [[view.minus, view.minus]]), ...offered];
    fill(
      this.controls,
      picker("Beside", /** @type {[string, string][]} */ (options), view.minus, (minus) =>
        this.change({ minus }),
      ),
      this.axes.pickers(this.choices, () => (this.drawControls(), this.change({}))),
      picker(
        "Shown",
        metrics.map((one) => [one.name, shown.variable(one.name, unitOf(one))]),
        view.metric,
        (metric) => this.change({ metric }),
      ),
    );
  }

  /** @param {Partial<{metric: string, minus: string}>} what */
  change(what) {
    Object.assign(this.view, what);
    const { metric, minus } = this.view;
    const usual = metric === this.metrics[0].name;
    this.session.kept.keep({ minus, ...this.axes.kept, metric: usual ? null : metric });
    this.look();
  }

  /** The request for the maps. In SI units, each study is converted with the values of its own structure. */
  question() {
    const { selection, shown } = this.session;
    const { x, y } = this.axes;
    const fixed = RECORD in selection.axes ? ["scale"] : [];
    const open = [x, y, RECORD, AMPLITUDE, ...fixed, ...(selection.worst ? [FREQUENCY] : [])];
    const at = Object.entries(selection.at(open));
    const [inX, inY, metric] = [x, y, this.view.metric].map((name) => shown.nameInSi(name));
    return {
      x: inX,
      y: inY,
      metric,
      ...Object.fromEntries(at.map(([name, value]) => [shown.nameInSi(name), shown.inSi(name, value)])),
      minus: this.view.minus,
    };
  }

  async look() {
    const mine = ++this.asked;
    const { record, shown } = this.session;
    this.maps.hidden = !this.view.minus;
    if (!this.view.minus) return fill(this.note, this.offered.length ? CHOOSE : NONE);
    try {
      const question = { ...this.question(), most: MOST };
      const path = studyPath(record.id, "resonance-map");
      const found = /** @type {MapDifference} */ (await ask(path, question));
      if (mine !== this.asked) return;
      this.answer = shown.mapInSi(found, { ...this.axes.both, metric: this.view.metric });
      fill(this.trouble);
      fill(this.note, prose(shown.words(found).note));
      this.name(found.studies[1]);
      await this.draw(this.answer);
    } catch (error) {
      if (mine !== this.asked) return;
      this.maps.hidden = true;
      fill(this.note);
      fill(this.trouble, refusalBox(error));
    }
  }

  /** Label the two maps and the map of the difference. @param {string} id id of the other study */
  name(id) {
    const { record } = this.session;
    const [one, other] = [record.name || record.id, this.others.find((each) => each.id === id)?.name || id];
    [one, other, `${one} less ${other}`].forEach((text, i) => fill(this.titles[i], text));
  }

  /** @param {MapDifference} map */
  async draw(map) {
    const { selection } = this.session;
    const [one, two, less] = this.charts;
    const point = selection.chosen ? this.axes.point : null;
    const other = {
      ...map,
      values: map.other,
      status: map.other_status,
      response_class: map.other_response_class,
    };
    const lines = (/** @type {MapDifference} */ of, /** @type {string[]} */ names) => () =>
      sideTraces(of, names);
    const difference = { ...map, values: map.difference, long_name: `difference, ${map.long_name}` };
    // if the maps are curves, the first figure shows both curves
    two.element.parentElement?.toggleAttribute("hidden", map.y.length === 1);
    await drawMap(
      one,
      map,
      () => sharedTraces(map, other, point),
      lines(map, ["this study", "the other study"]),
    );
    if (map.y.length > 1) await drawMap(two, map, () => sharedTraces(other, map, point));
    await drawMap(
      less,
      map.y.length === 1 ? difference : map,
      () => differenceTraces(map, point),
      lines(difference, ["difference"]),
    );
  }
}
