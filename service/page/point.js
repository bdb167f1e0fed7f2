/** Shows one design point: its frequency response, its motion, and its stored results. */
/** @import { Curve, Ranked, Session } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { button, debounced, el, fill, prose, quiet, say } from "./dom.js";
import { colour, CURVES, Figure, thisPoint } from "./figure.js";
import { help } from "./help.js";
import { MotionPanel } from "./motion.js";
import { duration, short } from "./numbers.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { times } from "./shown.js";
import { CLASS_LOOKS, designDimensions } from "./vocabulary.js";

const PATIENCE_MILLISECONDS = 350;
const NOT_COMPUTED = -1;

export class PointPanel {
  heading = el("h2", { id: "point" }, "Choose a point");
  curves = el("div");
  /** @type {AbortController | undefined} */
  asking;

  /** @param {Session} session @param {() => Ranked | null} best returns the best known design */
  constructor(session, best) {
    this.session = session;
    const { selection, record } = session;
    const go = () => {
      const design = best();
      if (design) selection.chooseDesign(design);
    };
    this.about = el(
      "div",
      {},
      quiet("Click the map, move the sliders, or take a design from the table."),
      button("Look at the best design", go),
    );
    this.curve = new Figure({
      label: "Frequency response of the point",
      name: `response-${record.id}`,
      height: 260,
      python: () => pythonLine(record.id, "frequency_response", selection.at([FREQUENCY])),
    });
    this.motion = new MotionPanel(session);
    this.element = el(
      "section",
      { class: "box point", "aria-labelledby": "point" },
      help("response-classes/", "classes of response"),
      this.heading,
      this.about,
      this.curves,
      this.motion.element,
    );
    selection.addEventListener(
      "chosen",
      debounced(PATIENCE_MILLISECONDS, () => this.look()),
    );
    if (selection.chosen) this.look();
  }

  async look() {
    const { session, heading, about } = this;
    if (!session.selection.chosen) return;
    this.asking?.abort();
    this.asking = new AbortController();
    const { signal } = this.asking;
    fill(heading, title(session));
    try {
      const [response, runs, periods] = await this.ask(signal);
      const place = this.frequencyPlace(response);
      fill(about, stored(session, response, runs, place));
      await this.drawCurve(response, place);
      // cycles after which the stored response repeats; 0 if the response has no known period
      const period = Math.max(0, periods?.values[place] ?? 0);
      await this.motion.look(response.frequency_ratio[place], period, signal);
      say(`${heading.textContent}: ${about.querySelector("dd")?.textContent ?? ""}`);
    } catch (error) {
      if (!signal.aborted) fill(about, refusalBox(error));
    }
  }

  /** Request the amplitude, the run time and the period over the frequency. @param {AbortSignal} signal */
  ask(signal) {
    const { selection, record, variables } = this.session;
    const path = studyPath(record.id, "frequency-response");
    const at = selection.at([FREQUENCY]);
    const along = (/** @type {string} */ metric) =>
      variables.includes(metric) ? ask(path, { ...at, metric }, { signal }) : null;
    return Promise.all([ask(path, at, { signal }), along("run_time"), along("period")]);
  }

  /**
   * The index of the selected frequency or, for the worst case over the frequencies, of the largest response.
   *
   * @param {Curve} response
   */
  frequencyPlace(response) {
    const { selection } = this.session;
    if (!selection.worst || empty(response)) return selection.place[FREQUENCY];
    const values = response.values.map((value) => value ?? -1);
    return values.indexOf(Math.max(...values));
  }

  /** @param {Curve} response @param {number} place */
  async drawCurve(response, place) {
    const { shown } = this.session;
    const { curve, curves } = this;
    if (response.frequency_ratio.length < 2) return fill(curves);
    if (!curve.element.isConnected) fill(curves, el("h3", {}, "Frequency response"), curve.element);
    await curve.draw(
      () => curveTraces(response, place, this.session),
      () => ({
        xaxis: { title: shown.frequency() },
        yaxis: { title: shown.variable("amplitude_ratio", response.long_name), rangemode: "tozero" },
      }),
    );
  }
}

/** The values of the point, with the symbols of the dimensions. @param {Session} session */
function title({ selection, record, shown }) {
  return designDimensions(record.definition).flatMap((name, i) => [
    i > 0 && " · ",
    el("span", { class: "one" }, shown.symbol(name), ` = ${shown.value(name, selection.value(name))}`),
  ]);
}

/** Whether no point of a curve is computed. @param {Curve} response */
function empty(response) {
  return response.values.every((value) => value === null);
}

/**
 * The stored results of the point.
 *
 * @param {Session} session
 * @param {Curve} response
 * @param {Curve | null} runs
 * @param {number} place
 */
function stored(session, response, runs, place) {
  const { words, selection, shown } = session;
  const error = response.amplitude_error?.[place];
  const kind = response.response_class && words.response_class[String(response.response_class[place])];
  const r = response.frequency_ratio[place];
  const at = `${shown.has(FREQUENCY) ? "f" : "r"} = ${shown.value(FREQUENCY, r)}`;
  const x = shown.has("amplitude_ratio") ? "X" : "X/Z";
  const entries = /** @type {[string, string][]} */ ([
    [
      selection.worst && !empty(response) ? `Largest ${x}, at ${at}` : `${x} at ${at}`,
      shown.value("amplitude_ratio", response.values[place], 6),
    ],
    ["Error", shown.error("amplitude_ratio", response.values[place], error)],
    ["Run time", duration(runs?.values[place])],
    ...(response.acceleration_g ? [["Acceleration", `at most ${short(response.acceleration_g, 2)} g`]] : []),
    ["Response", kind?.sentence ?? "–"],
    ["Status", words.status[String(response.status[place])]],
  ]);
  return [
    response.values.includes(null) &&
      response.status.includes(NOT_COMPUTED) &&
      quiet(
        empty(response)
          ? `The study has computed no frequency of this point yet; the motion below is the one at ${at}.`
          : "Not every frequency of this point is computed yet.",
      ),
    el(
      "dl",
      { class: "facts" },
      entries.map(([term, value]) =>
        el("div", { class: value.length > 24 ? "long" : "" }, el("dt", {}, term), el("dd", {}, prose(value))),
      ),
    ),
  ];
}

/** @param {Curve} response @param {number} place @param {Session} session */
function curveTraces(response, place, { words, shown }) {
  const [first] = CURVES();
  const kinds = response.response_class ?? [];
  const present = [...new Set(kinds)].filter((kind) => /** @type {number} */ (kind) >= 0);
  const r = times(response.frequency_ratio, shown.factor(FREQUENCY));
  const values = times(response.values, shown.factor("amplitude_ratio"));
  return [
    {
      type: "scatter",
      mode: "lines",
      x: r,
      y: values,
      line: { color: first, width: 1.5 },
      showlegend: false,
      connectgaps: false,
      error_y: {
        type: "data",
        array: times(response.amplitude_error ?? [], shown.factor("amplitude_ratio")),
        color: first,
        thickness: 1,
        width: 2,
      },
      hoverinfo: "skip",
    },
    ...present.map((kind) => {
      const here = r.map((_, i) => i).filter((i) => kinds[i] === kind);
      const look = CLASS_LOOKS[String(kind)];
      return {
        type: "scatter",
        mode: "markers",
        x: here.map((i) => r[i]),
        y: here.map((i) => values[i]),
        name: words.response_class[String(kind)].name,
        marker: {
          symbol: look.shape,
          color: look.colour,
          size: 8,
          line: { width: 0.8, color: colour("ink") },
        },
        hovertemplate: `%{x:.5~g}${shown.unit(FREQUENCY)}, %{y:.5~g}${shown.unit("amplitude_ratio")}`,
      };
    }),
    { ...thisPoint(16), x: [r[place]], y: [values[place]], showlegend: false },
  ];
}
