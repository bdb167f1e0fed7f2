/** Shows one damper of a suite: a result over the scale of each record, and the fragility curve. */
/** @import { Fragility, Row, Session, Trace, Variable } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, details, el, fill, grid, prose, quiet } from "./dom.js";
import { colour, CURVES, DASHES, Figure } from "./figure.js";
import { unitOf } from "./measures.js";
import { short } from "./numbers.js";
import { pythonLine } from "./python_line.js";
import { RECORD } from "./selection.js";
import { inBrackets, times } from "./shown.js";

const SCALE = "scale";
/** Largest number of records whose curves are drawn; more curves would hide each other. */
const MOST_RECORDS = 12;
const ONE_SCALE =
  "Compute the study with several factors on the records to see how the result grows, and how likely it is " +
  "that a limit is exceeded.";
const NO_SIZE =
  "This result is a code: it does not grow with the factor on a record, and no limit can be exceeded. " +
  "Choose another result under “Shown”.";
const SYMBOLS = ["circle", "square", "diamond", "x", "triangle-up"];

export class SurveyPoint {
  /** @type {Record<string, unknown>} the last request */
  asked = {};
  /** @type {Row[]} results under each record, over the scales */
  found = [];
  number = 0;
  title = el("h2", {}, "The damper");
  cases = el("div");
  note = el("p", { class: "quiet", role: "status" });
  why = el("p", { class: "quiet" });
  trouble = el("div");
  label = el("span", {}, "Limit");

  /**
   * @param {Session} session
   * @param {{metric: string, met: string}} view
   * @param {Variable[]} variables of the suite
   */
  constructor(session, view, variables) {
    this.session = session;
    this.view = view;
    this.variables = variables;
    const { selection, kept, changes } = session;
    this.scales = selection.axes[SCALE];
    this.rising = this.risingFigure();
    this.curve = new Figure({
      label: "Probability of exceeding the limit",
      name: `fragility-${session.record.id}`,
      height: 280,
      python: () => pythonLine(session.record.id, "fragility", this.asked),
    });
    const wanted = kept.number("limit", Number.MIN_VALUE, Infinity, 0) || "";
    const oninput = () => (this.keepLimit(), this.exceeded(this.number));
    this.box = el("input", { type: "number", step: "any", min: 0, value: wanted, oninput });
    /** The result to which the typed limit applies. */
    this.limited = wanted ? view.metric : "";
    this.exceeded = debounced(200, (/** @type {number} */ mine) => this.askFragility(mine));
    this.figures = this.drawFigures();
    const parts = [this.title, this.figures, this.why, this.trouble];
    this.element = el("section", { class: "box survey", "aria-label": "The damper" }, parts);
    selection.addEventListener("chosen", () => this.look());
    changes.addEventListener("grown", () => this.element.isConnected && this.look());
  }

  risingFigure() {
    const { record, selection } = this.session;
    const { records } = selection;
    return new Figure({
      label: "Result over the scale of each record",
      name: `incremental-${record.id}`,
      height: 380,
      python: () => pythonLine(record.id, "resonance_map", this.question(records[0])),
      clicked: ({ x, data: { name } }) =>
        records.includes(name) && selection.chooseValues({ [RECORD]: name, [SCALE]: x }),
    });
  }

  drawFigures() {
    return el(
      "div",
      { hidden: true },
      this.rising.element,
      this.cases,
      el("h3", {}, "Fragility"),
      el("label", { class: "field" }, this.label, this.box),
      this.curve.element,
      this.note,
    );
  }

  get metric() {
    return /** @type {Variable} */ (this.variables.find((one) => one.name === this.view.metric));
  }

  get factor() {
    return this.session.shown.factor(this.view.metric);
  }

  get damper() {
    return this.session.selection.at([RECORD, SCALE]);
  }

  /** The records whose curves are drawn. */
  get some() {
    return this.session.selection.records.slice(0, MOST_RECORDS);
  }

  /** Request the damper's results and draw them. */
  async look() {
    const mine = ++this.number;
    const { scales, figures, trouble, metric } = this;
    this.name();
    figures.hidden = scales.length < 2 || metric.coded;
    fill(this.why, figures.hidden && (scales.length < 2 ? ONE_SCALE : NO_SIZE));
    if (figures.hidden) return fill(trouble);
    try {
      const rows = await Promise.all(this.some.map((one) => this.overScales(one)));
      if (mine !== this.number) return;
      fill(trouble);
      if (this.limited !== this.view.metric) this.suggest(rows);
      fill(this.label, `Limit${inBrackets(metric.units)}`);
      this.found = rows;
      await this.drawRising();
      fill(this.cases, this.table(rows));
      this.exceeded(mine);
    } catch (error) {
      if (mine === this.number) fill(trouble, refusalBox(error));
    }
  }

  /** Write the values of the damper into the title. */
  name() {
    const { shown } = this.session;
    const at = Object.entries(this.damper).flatMap(([name, value], i) => [
      i > 0 && ", ",
      el("span", { class: "one" }, `${shown.called(name).toLowerCase()} ${shown.value(name, value)}`),
    ]);
    fill(this.title, "Damper with ", at);
  }

  drawRising() {
    const { rising, some, found, scales, box, metric } = this;
    return rising.draw(
      () => [...risingTraces(scales, some, found), ...limitTrace(scales, Number(box.value))],
      () => ({
        xaxis: { title: "factor on the record" },
        yaxis: { title: unitOf(metric), rangemode: "tozero" },
        legend: { orientation: "h", y: -0.3, yanchor: "top" },
      }),
    );
  }

  /**
   * The request for the results of the damper under one record, over the scales.
   *
   * @param {string} record
   * @returns {{y: string} & Record<string, unknown>}
   */
  question(record) {
    const { selection } = this.session;
    const others = Object.keys(selection.axes).filter((name) => name !== SCALE && name !== RECORD);
    const y = others.find((name) => selection.axes[name].length === 1) ?? "clearance_m";
    return { x: SCALE, y, metric: this.view.metric, record, ...selection.at([RECORD, SCALE, y]) };
  }

  /** Request the results under one record over the scales, in the shown units. @param {string} one */
  async overScales(one) {
    const { selection, record } = this.session;
    const question = this.question(one);
    const { y } = question;
    const { values } = await ask(studyPath(record.id, "resonance-map"), question);
    return times(values[selection.axes[y].length === 1 ? 0 : selection.place[y]], this.factor);
  }

  /** Keep the typed limit in the address, in the unit of the box. */
  keepLimit() {
    const limit = Number(this.box.value);
    this.limited = this.view.metric;
    this.session.kept.keep({ limit: limit > 0 ? limit : null });
  }

  /** Show the median of the results as an example of a limit. @param {Row[]} rows */
  suggest(rows) {
    const known = rows
      .flat()
      .filter((value) => value !== null)
      .sort((a, b) => a - b);
    this.box.value = "";
    this.box.placeholder = known.length ? `e.g. ${short(known[Math.floor(known.length / 2)], 2)}` : "";
    this.limited = this.view.metric;
  }

  /**
   * Draw the fragility curve. Nothing is drawn if a newer request has begun, because the limit may not apply
   * to the result of the newer request.
   *
   * @param {number} mine number of the request
   */
  async askFragility(mine) {
    if (mine !== this.number) return;
    const { box, curve, note, trouble, view } = this;
    const limit = Number(box.value);
    curve.element.hidden = !(limit > 0);
    if (!(limit > 0)) return fill(note, "Name a limit above 0.");
    this.asked = { threshold: limit / this.factor, metric: view.metric, ...this.damper };
    try {
      const answer = await ask(studyPath(this.session.record.id, "fragility"), this.asked);
      if (mine !== this.number || Number(box.value) !== limit) return;
      fill(trouble);
      fill(note, prose(answer.note));
      await curve.draw(
        () => curveTraces(answer),
        () => ({
          xaxis: { title: "factor on the records" },
          yaxis: { title: "probability of exceeding", range: [-0.04, 1.04] },
        }),
      );
      await this.drawRising();
    } catch (error) {
      if (mine === this.number) fill(trouble, refusalBox(error));
    }
  }

  /** @param {Row[]} rows */
  table(rows) {
    const { records } = this.session.selection;
    const heads = [`Record; ${unitOf(this.metric)} at ×`, ...this.scales.map((scale) => short(scale))];
    const cells = rows.map((row, i) => [records[i], ...row.map((value) => short(value, 4))]);
    return details(
      "All cases as a table",
      grid("Cases of the damper", heads, cells),
      records.length > MOST_RECORDS &&
        quiet(`The first ${MOST_RECORDS} of ${records.length} records; the fragility includes all.`),
    );
  }
}

/** @param {number[]} scales @param {string[]} names @param {Row[]} rows @returns {Trace[]} */
function risingTraces(scales, names, rows) {
  return rows.map((row, i) => ({
    type: "scatter",
    mode: "lines+markers",
    name: names[i],
    x: scales,
    y: row,
    line: { color: CURVES()[i % 5], dash: DASHES[Math.floor(i / 5) % 5], width: 1.5 },
    marker: { symbol: SYMBOLS[i % 5], size: 6 },
    hovertemplate: `${names[i]}<br>× %{x}: %{y:.5~g}<extra></extra>`,
  }));
}

/** @param {number[]} scales @param {number} limit @returns {Trace[]} */
function limitTrace(scales, limit) {
  if (!(limit > 0)) return [];
  return [
    {
      type: "scatter",
      mode: "lines",
      name: "limit",
      x: [scales[0], scales[scales.length - 1]],
      y: [limit, limit],
      line: { color: colour("ink"), dash: "dash", width: 1.5 },
      hoverinfo: "skip",
    },
  ];
}

/** @param {Fragility} answer @returns {Trace[]} */
function curveTraces({ records, scale, exceeded, probability, median_scale }) {
  const shares = {
    type: "scatter",
    mode: "markers",
    name: `share of ${records} records`,
    x: scale,
    y: exceeded,
    marker: { color: CURVES()[0], size: 9 },
  };
  const fitted = {
    type: "scatter",
    mode: "lines",
    name: "fitted curve",
    x: scale,
    y: probability,
    line: { color: CURVES()[1] },
  };
  return median_scale === undefined ? [shares] : [shares, fitted];
}
