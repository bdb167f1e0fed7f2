/** One damper of a survey: its result over the scale of every record, and how likely it exceeds a limit. */
/** @import { Fragility, Session, Trace, Variable } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, el, fill, grid, prose } from "./dom.js";
import { colour, CURVES, DASHES, figure } from "./figure.js";
import { unitOf } from "./measures.js";
import { short } from "./numbers.js";
import { pythonLine } from "./python_line.js";
import { RECORD } from "./selection.js";
import { inBrackets } from "./shown.js";

const SCALE = "scale";
/** Most records whose curves are drawn; more would hide each other. */
const MOST_RECORDS = 12;
const ONE_SCALE =
  "Compute several factors on the records to see how the result grows and how likely a limit is exceeded.";
const NO_SIZE =
  "This result is a code: it does not grow with the factor on a record, and no limit can be exceeded. " +
  "Choose another result under “Shown”.";
const SYMBOLS = ["circle", "square", "diamond", "x", "triangle-up"];

/**
 * @param {Session} session
 * @param {{metric: string, met: string}} view
 * @param {Variable[]} variables of the suite
 */
export function surveyPoint({ selection, record, shown, changes, kept }, view, variables) {
  const id = record.id;
  const scales = selection.axes[SCALE];
  const { records } = selection;
  /** @type {Record<string, unknown>} what was asked for last */
  let asked = {};
  /** @type {(number | null)[][]} results under each record, over the scales */
  let found = [];
  let number = 0;
  const rising = figure({
    label: "Result over the scale of each record",
    name: `incremental-${id}`,
    height: 380,
    python: () => pythonLine(id, "resonance_map", question(records[0])),
    clicked: ({ x, data: { name } }) =>
      records.includes(name) && selection.chooseValues({ [RECORD]: name, [SCALE]: x }),
  });
  const curve = figure({
    label: "Probability of exceeding the limit",
    name: `fragility-${id}`,
    height: 280,
    python: () => pythonLine(id, "fragility", asked),
  });
  const title = el("h2", {}, "The damper");
  const cases = el("div");
  const note = el("p", { class: "quiet", role: "status" });
  const trouble = el("div");
  const box = el("input", {
    type: "number",
    step: "any",
    min: 0,
    oninput: () => (keepLimit(), exceeded(number)),
  });
  const wanted = kept.number("limit", Number.MIN_VALUE, Infinity, 0);
  if (wanted) Object.assign(box, { value: String(wanted) }).dataset.metric = view.metric;
  const label = el("span", {}, "Limit");
  const figures = el(
    "div",
    { hidden: true },
    rising.element,
    cases,
    el("h3", {}, "Fragility"),
    el("label", { class: "field" }, label, box),
    curve.element,
    note,
  );
  const why = el("p", { class: "quiet" });
  const element = el(
    "section",
    { class: "box survey", "aria-label": "The damper" },
    title,
    figures,
    why,
    trouble,
  );

  const metric = () => /** @type {Variable} */ (variables.find((one) => one.name === view.metric));
  const factor = () => shown.factor(view.metric);
  const nameOf = (/** @type {string} */ name) => shown.called(name).toLowerCase();
  const damper = () => selection.at([RECORD, SCALE]);
  const named = () => unitOf(metric());

  /** Ask for the damper's results and draw them. */
  async function look() {
    const mine = ++number;
    fill(
      title,
      "Damper with ",
      Object.entries(damper()).flatMap(([name, value], i) => [
        i > 0 && ", ",
        el("span", { class: "one" }, `${nameOf(name)} ${shown.value(name, value)}`),
      ]),
    );
    figures.hidden = scales.length < 2 || metric().coded;
    fill(why, figures.hidden && (scales.length < 2 ? ONE_SCALE : NO_SIZE));
    if (figures.hidden) return fill(trouble);
    try {
      const some = records.slice(0, MOST_RECORDS);
      const rows = await Promise.all(some.map((one) => overScales(one)));
      if (mine !== number) return;
      fill(trouble);
      if (box.dataset.metric !== view.metric) suggest(rows);
      fill(label, `Limit${inBrackets(metric().units)}`);
      found = rows;
      await drawRising();
      fill(cases, table(some, rows));
      exceeded(mine);
    } catch (error) {
      if (mine === number) fill(trouble, refusalBox(error));
    }
  }

  const drawRising = () =>
    rising.draw(
      () => [...risingTraces(records.slice(0, MOST_RECORDS), found), ...limitTrace(Number(box.value))],
      () => ({
        xaxis: { title: { text: "factor on the record" } },
        yaxis: { title: { text: named() }, rangemode: "tozero" },
        legend: { orientation: "h", y: -0.3, yanchor: "top" },
      }),
    );

  /**
   * The results of the damper under one record, over the scales.
   *
   * @param {string} one
   * @returns {{y: string} & Record<string, unknown>}
   */
  function question(one) {
    const y =
      Object.keys(selection.axes).find(
        (name) => name !== SCALE && name !== RECORD && selection.axes[name].length === 1,
      ) ?? "clearance_m";
    return { x: SCALE, y, metric: view.metric, record: one, ...selection.at([RECORD, SCALE, y]) };
  }

  /** The same, in units that are shown. @param {string} one */
  async function overScales(one) {
    const { y, ...asked } = question(one);
    const answer = await ask(studyPath(id, "resonance-map"), { y, ...asked });
    const row = answer.values[selection.axes[y].length === 1 ? 0 : selection.place[y]];
    return row.map((value) => (value === null ? null : value * factor()));
  }

  /** Keep the limit in the address, in the unit that it is typed in. */
  function keepLimit() {
    box.dataset.metric = view.metric;
    kept.keep({ limit: Number(box.value) > 0 ? Number(box.value) : null });
  }

  /**
   * The middle of what is there, as an example: no limit counts that nobody named.
   *
   * @param {(number | null)[][]} rows
   */
  function suggest(rows) {
    const known = rows
      .flat()
      .filter((value) => value !== null)
      .sort((a, b) => Number(a) - Number(b));
    box.value = "";
    box.placeholder = known.length === 0 ? "" : `e.g. ${short(known[Math.floor(known.length / 2)], 2)}`;
    box.dataset.metric = view.metric;
  }

  /**
   * Asked by the look whose number it is given: by now another result may be shown, of which this is no
   * limit.
   */
  const exceeded = debounced(200, async (/** @type {number} */ mine) => {
    if (mine !== number) return;
    const limit = Number(box.value);
    curve.element.hidden = !(limit > 0);
    if (!(limit > 0)) return fill(note, "Name a limit above 0.");
    asked = { threshold: limit / factor(), metric: view.metric, ...damper() };
    try {
      const answer = await ask(studyPath(id, "fragility"), asked);
      if (mine !== number || Number(box.value) !== limit) return;
      fill(trouble);
      fill(note, prose(answer.note));
      await curve.draw(
        () => curveTraces(answer),
        () => ({
          xaxis: { title: { text: "factor on the records" } },
          yaxis: { title: { text: "probability of exceeding" }, range: [-0.04, 1.04] },
        }),
      );
      await drawRising();
    } catch (error) {
      if (mine === number) fill(trouble, refusalBox(error));
    }
  });

  /** @param {string[]} names @param {(number | null)[][]} rows @returns {Trace[]} */
  function risingTraces(names, rows) {
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

  /** @param {number} limit */
  function limitTrace(limit) {
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
  function curveTraces(answer) {
    const traces = [
      {
        type: "scatter",
        mode: "markers",
        name: `share of ${answer.records} records`,
        x: answer.scale,
        y: answer.exceeded,
        marker: { color: CURVES()[0], size: 9 },
      },
    ];
    if (answer.median_scale === undefined) return traces;
    return [
      ...traces,
      {
        type: "scatter",
        mode: "lines",
        name: "fitted curve",
        x: answer.scale,
        y: answer.probability,
        line: { color: CURVES()[1] },
      },
    ];
  }

  /** @param {string[]} names @param {(number | null)[][]} rows */
  function table(names, rows) {
    return el(
      "details",
      {},
      el("summary", {}, "All cases as a table"),
      grid(
        "Cases of the damper",
        [`Record; ${named()} at ×`, ...scales.map((scale) => short(scale))],
        rows.map((row, i) => [names[i], ...row.map((value) => (value === null ? "–" : short(value, 4)))]),
      ),
      records.length > MOST_RECORDS &&
        el(
          "p",
          { class: "quiet" },
          `The first ${MOST_RECORDS} of ${records.length} records; the fragility is of all.`,
        ),
    );
  }

  selection.addEventListener("chosen", look);
  changes.addEventListener("grown", () => element.isConnected && look());
  return { element, look };
}
