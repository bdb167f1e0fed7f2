/** One design point: its curve over the frequency, its motion, and what is known about it. */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, el, fill, prose, say } from "./dom.js";
import { colour, CURVES, figure } from "./figure.js";
import { duration, short } from "./numbers.js";
import { sendPatiently } from "./patience.js";
import { FREQUENCY } from "./selection.js";
import { inUnit } from "./sliders.js";
import { CLASS_LOOKS, DIMENSIONS, symbol } from "./vocabulary.js";

const OF_PARTICLE = ["clearance_ratio", "restitution", "mass_ratio"];
const CYCLES = 6;
/** The most that the service sends: with fewer, impacts would be among what is left out. */
const SAMPLES = 20000;
const PATIENCE_MILLISECONDS = 350;

/**
 * @param {import("./study.js").Session} session
 * @param {() => any} best the best design that is known, or null
 */
export function pointPanel(session, best) {
  const { selection, record } = session;
  const heading = el("h2", { id: "point" }, "Choose a point");
  const start = el("button", { type: "button", onclick: () => best() && selection.chooseValues(designOf(best(), selection)) }, "Look at the optimum");
  const about = el("div", {}, el("p", { class: "quiet" }, "Click the map, move the sliders, or take a design from the table."), start);
  const curve = figure({ label: "Frequency response of the point", name: `response-${record.id}`, height: 260 });
  const time = figure({ label: "Time history of the point", name: `time-history-${record.id}`, height: 240 });
  const phase = figure({ label: "Phase portrait of the point", name: `phase-portrait-${record.id}`, height: 280 });
  const curves = el("div");
  const motion = el("div");
  /** @type {AbortController | undefined} */
  let asking;

  async function look() {
    if (!selection.chosen) return;
    asking?.abort();
    asking = new AbortController();
    const options = { signal: asking.signal };
    const at = selection.at([FREQUENCY]);
    fill(heading, title(session));
    try {
      const path = studyPath(record.id, "frequency-response");
      const [response, times] = await Promise.all([
        ask(path, at, options),
        session.variables.includes("run_time") ? ask(path, { ...at, metric: "run_time" }, options) : null,
      ]);
      const place = frequencyPlace(response);
      fill(about, stored(session, response, times, place));
      await drawCurve(response, place);
      await drawMotion(response.frequency_ratio[place], options.signal);
      say(`${heading.textContent}: ${about.querySelector("dd")?.textContent ?? ""}`);
    } catch (error) {
      if (options.signal.aborted) return;
      fill(about, refusalBox(error));
    }
  }

  /** The frequency that is looked at: where the response is largest, or what the slider says. @param {any} response */
  function frequencyPlace(response) {
    if (!selection.worst) return selection.place[FREQUENCY];
    const values = response.values.map((/** @type {any} */ value) => value ?? -1);
    return values.indexOf(values.reduce((/** @type {number} */ a, /** @type {number} */ b) => Math.max(a, b)));
  }

  /** @param {any} response @param {number} place */
  async function drawCurve(response, place) {
    if (response.frequency_ratio.length < 2) return fill(curves);
    if (!curve.element.isConnected) fill(curves, el("h3", {}, "Frequency response"), curve.element);
    await curve.draw(() => curveTraces(response, place, session.words), () => ({
      xaxis: { title: { text: "frequency ratio r" } },
      yaxis: { title: { text: response.long_name }, rangemode: "tozero" },
    }));
  }

  /** @param {number} r @param {AbortSignal} signal */
  async function drawMotion(r, signal) {
    const goesOn = el("p", { class: "quiet", role: "status" }, "Computing the motion …");
    if (!time.element.isConnected) fill(motion, goesOn);
    /** @param {string} words */
    const tell = (words) => {
      // a motion that is shown stays until the next is there, unless that takes as long as a compiler
      if (words && !goesOn.isConnected) fill(motion, goesOn);
      fill(goesOn, words || "Computing the motion …");
    };
    try {
      const answer = await sendPatiently("simulate", design(session, r), tell, signal);
      fill(
        motion,
        el("h3", {}, `Motion at r = ${short(r)}`),
        startNote(record, answer),
        time.element,
        phase.element,
        measures(answer, session.words),
      );
      await time.draw(() => timeTraces(answer.history), () => ({
        xaxis: { title: { text: "time ω<sub>n</sub>t" } }, yaxis: { title: { text: "displacement / Z" } },
      }));
      await phase.draw(() => phaseTraces(answer.history), () => ({
        xaxis: { title: { text: "displacement u/Z" } }, yaxis: { title: { text: "velocity u̇/(Zω<sub>n</sub>)" } },
      }));
    } catch (error) {
      if (!signal.aborted) fill(motion, refusalBox(error));
    }
  }

  const soon = debounced(PATIENCE_MILLISECONDS, look);
  selection.addEventListener("chosen", soon);
  if (selection.chosen) look();
  return el("section", { class: "box point", "aria-labelledby": "point" }, heading, about, curves, motion);
}

/** What a design says about the dimensions that vary. @param {any} design @param {import("./selection.js").Selection} selection */
function designOf(design, selection) {
  return Object.fromEntries(selection.varied.filter((name) => name !== FREQUENCY).map((name) => [name, design[name]]));
}

/** The point in symbols. @param {import("./study.js").Session} session */
function title({ selection, record }) {
  const named = DIMENSIONS.filter((name) => name !== FREQUENCY && (record.definition.particle !== false || !OF_PARTICLE.includes(name)));
  return named.flatMap((name, i) => [
    i > 0 && " · ",
    el("span", { class: "one" }, symbol(name), ` = ${short(selection.value(name))}${inUnit(name, selection.value(name), record.definition)}`),
  ]);
}

/** What the study has stored about the point. @param {import("./study.js").Session} session @param {any} response @param {any} times @param {number} place */
function stored(session, response, times, place) {
  const { words, selection } = session;
  const error = response.amplitude_error?.[place];
  const kind = response.response_class && words.response_class[String(response.response_class[place])];
  const r = short(response.frequency_ratio[place]);
  const entries = /** @type {[string, string][]} */ ([
    [selection.worst ? `Largest X/Z, at r = ${r}` : `X/Z at r = ${r}`, short(response.values[place], 6)],
    ["Error", error === null || error === undefined ? "–" : `± ${short(error, 2)}`],
    ["Run time", duration(times?.values[place])],
    ["Response", kind?.sentence ?? "–"],
    ["Status", words.status[String(response.status[place])]],
  ]);
  return el("dl", { class: "facts" }, entries.map(([term, value]) => el("div", { class: value.length > 24 ? "long" : "" }, el("dt", {}, term), el("dd", {}, prose(value)))));
}

/** What the simulation measured. @param {any} answer @param {any} words */
function measures(answer, words) {
  const names = ["impacts_per_cycle", "impact_speed_max", "period", "floquet_multiplier", "stick_fraction", "dissipation_viscous", "dissipation_friction", "dissipation_impact"];
  const known = words.variables.filter((/** @type {any} */ v) => names.includes(v.name) && answer.metrics[v.name] !== undefined && answer.metrics[v.name] !== null);
  return el("dl", { class: "facts" }, known.map((/** @type {any} */ v) => el("div", {}, el("dt", { title: v.doc }, v.long_name), el("dd", {}, short(answer.metrics[v.name], 4)))));
}

/** The point as a request. @param {import("./study.js").Session} session @param {number} r */
function design({ selection, record }, r) {
  const { particle, contact } = record.definition;
  const names = DIMENSIONS.filter((name) => name !== FREQUENCY && (particle !== false || !OF_PARTICLE.includes(name)));
  const ratios = Object.fromEntries(names.map((name) => [name, selection.value(name)]));
  return { ...ratios, frequency_ratio: r, particle: particle !== false, ...(contact ? { contact } : {}), history: CYCLES, samples: SAMPLES };
}

/** @param {any} record @param {any} answer */
function startNote(record, answer) {
  const start = record.definition.start ?? "rest";
  const other = start === "rest" ? "" : " The study starts its points elsewhere, so this may be another response than the stored one.";
  return el("p", { class: "quiet" }, `From rest, ${answer.events.impacts} impacts shown.${other}`.replace("From rest, 0 impacts shown.", "From rest; no impact in what is shown."));
}

/** @param {any} response @param {number} place @param {any} words */
function curveTraces(response, place, words) {
  const [first] = CURVES();
  const kinds = response.response_class ?? [];
  const present = [...new Set(kinds)].filter((kind) => /** @type {number} */ (kind) >= 0);
  const r = response.frequency_ratio;
  return [
    {
      type: "scatter", mode: "lines", x: r, y: response.values, line: { color: first, width: 1.5 }, showlegend: false, connectgaps: false,
      error_y: { type: "data", array: response.amplitude_error, color: first, thickness: 1, width: 2 }, hoverinfo: "skip",
    },
    ...present.map((kind) => {
      const here = r.map((/** @type {number} */ _, /** @type {number} */ i) => i).filter((/** @type {number} */ i) => kinds[i] === kind);
      const look = CLASS_LOOKS[String(kind)];
      return {
        type: "scatter", mode: "markers", x: here.map((/** @type {number} */ i) => r[i]), y: here.map((/** @type {number} */ i) => response.values[i]),
        name: words.response_class[String(kind)].name, marker: { symbol: look.shape, color: look.colour, size: 8, line: { width: 0.8, color: colour("ink") } },
        hovertemplate: "r = %{x:.5~g}, X/Z = %{y:.5~g}",
      };
    }),
    { type: "scatter", mode: "markers", x: [r[place]], y: [response.values[place]], marker: { symbol: "circle-open", size: 16, color: "#ff3030", line: { width: 2.5 } }, showlegend: false, hoverinfo: "skip" },
  ];
}

/** @param {any} history */
function timeTraces(history) {
  const [first, second] = CURVES();
  const traces = /** @type {any[]} */ ([{ type: "scatter", mode: "lines", x: history.time, y: history.u, name: "structure", line: { color: first, width: 1.6 } }]);
  if (known(history.p)) traces.push({ type: "scatter", mode: "lines", x: history.time, y: history.p, name: "particle", line: { color: second, width: 1.2, dash: "dot" } });
  const struck = impacts(history);
  if (struck.length) traces.push(impactMarks(struck.map((i) => history.time[i]), struck.map((i) => history.u[i])));
  return traces;
}

/** @param {any} history */
function phaseTraces(history) {
  const [first] = CURVES();
  const struck = impacts(history);
  const traces = /** @type {any[]} */ ([{ type: "scatter", mode: "lines", x: history.u, y: history.u_rate, name: "structure", line: { color: first, width: 1.2 } }]);
  if (struck.length) traces.push(impactMarks(struck.map((i) => history.u[i]), struck.map((i) => history.u_rate[i])));
  return traces;
}

/** @param {number[]} x @param {number[]} y */
function impactMarks(x, y) {
  return { type: "scatter", mode: "markers", x, y, name: "impact", marker: { symbol: "x", size: 7, color: CURVES()[2] } };
}

/** @param {any} history @returns {number[]} */
function impacts(history) {
  return (history.impact ?? []).flatMap((/** @type {number} */ struck, /** @type {number} */ i) => (struck ? [i] : []));
}

/** @param {any[] | undefined} column */
function known(column) {
  return column !== undefined && column.some((value) => value !== null);
}
