/** The steady motion of one design: sketch, history, phase portrait, spectrum, forces and energies. */
/** @import { Session, Shown, Simulated, StudyRecord, Trace } from "./types.js" */

import { refusalBox } from "./api.js";
import { el, fill, quiet } from "./dom.js";
import { colour, CURVES, DASHES, Figure } from "./figure.js";
import { History } from "./history.js";
import { short } from "./numbers.js";
import { sendPatiently } from "./patience.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { sketch } from "./sketch.js";
import { designDimensions } from "./vocabulary.js";

const COMPUTING = "Computing the motion …";
/** Number of cycles to show of a response that repeats, rounded down to complete periods. */
const CYCLES = 6;
const MOST_CYCLES = 60;
/** Number of cycles to show of a response that does not repeat, or whose period is unknown. */
const CYCLES_OF_OTHERS = 12;
/** Largest number of samples that the service sends; fewer samples could leave out impacts. */
const SAMPLES = 20000;
/** Space between a closed curve and the frame, as a share of the curve's width. */
const MARGIN = 0.05;
/** Values below this share of the largest amplitude are rounding errors. */
const NOTHING = 1e-6;
const MEASURES = [
  "impacts_per_cycle",
  "impact_speed_max",
  "period",
  "floquet_multiplier",
  "stick_fraction",
  "dissipation_per_cycle",
];
const FORCES = [
  ["spring", "spring"],
  ["damping", "damping of the structure"],
  ["friction", "friction"],
  ["excitation", "force F₀ sin ωt"],
];
const LOSSES = /** @type {[string, string][]} */ ([
  ["dissipation_viscous", "damping of the structure"],
  ["dissipation_friction", "friction"],
  ["dissipation_impact", "impacts"],
  ["dissipation_particle", "friction of the particle"],
]);

/** @typedef {ReturnType<typeof unitsOf>} Units */

export class MotionPanel {
  element = el("div");
  /** @type {Record<string, unknown>} the last request */
  asked = {};

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    this.units = unitsOf(session.shown);
    this.time = this.figure("Time history of the point", "time-history", 340);
    this.phase = this.figure("Phase portrait of the point", "phase-portrait", 280);
    this.spectrum = this.figure("Spectrum of the point", "spectrum", 240);
    this.forces = this.figure("Forces on the structure at the point", "forces", 240);
  }

  /** @param {string} label @param {string} stem @param {number} height */
  figure(label, stem, height) {
    const python = () => pythonLine(null, "simulate", this.asked);
    return new Figure({ label, name: `${stem}-${this.session.record.id}`, height, python });
  }

  /**
   * Compute and draw the motion of the point.
   *
   * @param {number} r frequency ratio
   * @param {number} period cycles after which the stored response repeats; 0 if the response does not repeat
   * @param {AbortSignal} signal
   */
  async look(r, period, signal) {
    const { element, time, session } = this;
    const goesOn = el("p", { class: "quiet", role: "status" }, COMPUTING);
    if (!time.element.isConnected) fill(element, goesOn);
    /** @param {string} words */
    const tell = (words) => {
      // the old motion is shown until the new motion arrives; if kernels are compiled, a message replaces it
      if (words && !goesOn.isConnected) fill(element, goesOn);
      fill(goesOn, words || COMPUTING);
    };
    try {
      const question = design(session, r, cyclesShown(period));
      this.asked = question;
      const answer = await sendPatiently("simulate", question, tell, signal);
      const history = new History(answer.history, r);
      const clearance = history.particle ? (question.clearance_ratio ?? null) : null;
      this.show(answer, history, { clearance, friction: question.friction_ratio ?? 0 });
      await this.draw(answer, history, clearance);
    } catch (error) {
      if (!signal.aborted) fill(element, refusalBox(error));
    }
  }

  /**
   * @param {Simulated} answer
   * @param {History} history
   * @param {{clearance: number | null, friction: number}} ratios
   */
  show(answer, history, ratios) {
    const { session, units, time, phase, spectrum, forces } = this;
    const { shown, record } = session;
    fill(
      this.element,
      el("h3", {}, `Motion at ${shown.has(FREQUENCY) ? "f" : "r"} = ${shown.value(FREQUENCY, history.r)}`),
      shownNote(record, answer, history),
      sketch(history, ratios, (u) => `${short(u * units.ofLength, 3)} ${units.plain}`),
      time.element,
      phase.element,
      spectrum.element,
      forces.element,
      quiet(
        "Spring, damping and friction; an instantaneous impact has no finite force, so it is not " +
          "in the figure.",
      ),
      measures(answer, session),
    );
  }

  /** @param {Simulated} answer @param {History} history @param {number | null} clearance */
  async draw(answer, history, clearance) {
    const { units, time, phase, spectrum, forces } = this;
    const { shown } = this.session;
    await time.draw(
      () => timeTraces(history, clearance, units),
      () => timeLayout(history, units),
    );
    await phase.draw(
      () => phaseTraces(history, units),
      () => phaseLayout(history, units),
    );
    await spectrum.draw(
      () => spectrumTraces(answer.spectrum, history.length, history.r, units),
      () => spectrumLayout(units),
    );
    await forces.draw(
      () => forceTraces(history.cycles, answer.forces, shown.factor("friction_ratio")),
      () => forceLayout(history, shown),
    );
  }
}

/** @param {History} history @param {Units} units */
function phaseLayout(history, units) {
  const traces = phaseTraces(history, units);
  return {
    xaxis: { title: `displacement x ${units.length}`, ...around(traces, "x") },
    yaxis: { title: `velocity ${units.speed}`, ...around(traces, "y") },
  };
}

/** @param {Units} units */
function spectrumLayout(units) {
  const title = `amplitude of x ${units.length}`;
  return {
    xaxis: { title: units.frequencyTitle },
    yaxis: { title, type: "log", dtick: 1, exponentformat: "power" },
    showlegend: false,
    bargap: 0.3,
  };
}

/** @param {History} history @param {Shown} shown */
function forceLayout(history, shown) {
  const unit = shown.has("friction_ratio") ? " [N]" : ", over kZ";
  return {
    xaxis: { title: "cycles of the excitation", range: [0, history.length] },
    yaxis: { title: `force on the structure${unit}` },
  };
}

/**
 * The range of an axis with some space around the curves, because a line at the frame would look cut off.
 *
 * @param {{x: number[], y: number[]}[]} traces
 * @param {"x" | "y"} axis
 */
function around(traces, axis) {
  const values = traces.flatMap((trace) => [...trace[axis]]);
  const [low, high] = values.reduce(
    ([least, most], value) => [Math.min(least, value), Math.max(most, value)],
    [Infinity, -Infinity],
  );
  const room = MARGIN * (high - low);
  return { autorangeoptions: { include: [low - room, high + room] } };
}

/** Number of cycles to show, if possible a multiple of the period. @param {number} period */
function cyclesShown(period) {
  if (period < 1) return CYCLES_OF_OTHERS;
  return period <= CYCLES ? period * Math.floor(CYCLES / period) : Math.min(period, MOST_CYCLES);
}

/** Units of lengths, speeds and frequencies. Either all are ratios, or none is. @param {Shown} shown */
function unitsOf(shown) {
  const inUnits = shown.has("impact_speed_max");
  const factor = (/** @type {string} */ name) => (inUnits ? shown.factor(name) : 1);
  return {
    ofLength: factor("amplitude_ratio"),
    ofSpeed: factor("impact_speed_max"),
    ofFrequency: factor(FREQUENCY),
    plain: inUnits ? "mm" : "Z",
    length: inUnits ? "[mm]" : "/ Z",
    speed: inUnits ? "[m/s]" : "ẋ / (Z ω<sub>n</sub>)",
    frequencyTitle: inUnits ? "frequency [Hz]" : "frequency over the natural frequency",
  };
}

/**
 * The request for the simulation of the point.
 *
 * @param {Session} session
 * @param {number} r
 * @param {number} cycles
 * @returns {{clearance_ratio?: number, friction_ratio?: number} & Record<string, unknown>}
 */
function design({ selection, record }, r, cycles) {
  const { particle, contact, excitation } = record.definition;
  const ratios = Object.fromEntries(
    designDimensions(record.definition).map((name) => [name, selection.value(name)]),
  );
  return {
    ...ratios,
    frequency_ratio: r,
    particle: particle !== false,
    ...(contact ? { contact } : {}),
    ...(excitation ? { excitation } : {}),
    history: cycles,
    samples: SAMPLES,
  };
}

/**
 * The caption of the figures.
 *
 * @param {StudyRecord} record
 * @param {Simulated} answer
 * @param {History} history
 */
function shownNote(record, answer, history) {
  const period = answer.metrics.period ?? 0;
  const cycles = `${history.length} cycle${history.length === 1 ? "" : "s"}`;
  const repeats =
    period >= 1 && history.length % period === 0
      ? `: the response repeats after ${period === 1 ? "each" : period}`
      : "";
  const struck = history.impacts.length;
  const impacts = history.particle
    ? ` ${struck === 0 ? "No impact" : struck === 1 ? "One impact" : `${struck} impacts`} in them.`
    : "";
  const start = record.definition.start ?? "rest";
  const other =
    start === "rest"
      ? ""
      : " The study uses other starts, so this response may differ from the stored one.";
  return quiet(
    `${cycles} of the steady response that a start from rest leads to${repeats}.${impacts}${other}`,
  );
}

/** The results of the simulation with their values. @param {Simulated} answer @param {Session} session */
function measures({ metrics }, { words, shown }) {
  const measured = (/** @type {string} */ name) => metrics[name] ?? 0;
  const known = words.variables.filter(
    (v) => MEASURES.includes(v.name) && metrics[v.name] !== undefined && metrics[v.name] !== null,
  );
  /** @param {string} name */
  const value = (name) => {
    if (name === "period" && measured(name) < 1) return "none: it does not repeat";
    return shown.value(name, metrics[name], 4);
  };
  const total = LOSSES.reduce((sum, [name]) => sum + measured(name), 0);
  const shares =
    total > 0 &&
    LOSSES.filter(([name]) => measured(name) > 0).map(
      ([name, of]) => `${of} ${short((100 * measured(name)) / total, 3)} %`,
    );
  return el(
    "dl",
    { class: "facts" },
    shares &&
      el("div", { class: "long" }, el("dt", {}, "Where the energy goes"), el("dd", {}, shares.join(", "))),
    known.map((v) => el("div", {}, el("dt", { title: v.doc }, v.long_name), el("dd", {}, value(v.name)))),
  );
}

/** @param {History} history @param {number | null} clearance @param {Units} units */
function timeTraces(history, clearance, units) {
  const [first, second, third] = CURVES();
  const x = history.cycles;
  const { u } = history.columns;
  const line = { type: "scatter", mode: "lines", x };
  const base = x.map((cycle) => history.base(cycle) * units.ofLength);
  const traces = /** @type {Trace[]} */ ([
    {
      ...line,
      y: u.map((value) => value * units.ofLength),
      name: "structure x",
      line: { color: first, width: 1.6 },
    },
    { ...line, y: base, name: "base z", line: { color: colour("quiet"), width: 1, dash: "dot" } },
  ]);
  const struck = history.impacts;
  if (struck.length)
    traces.push(
      impactMarks(
        struck.map((i) => x[i]),
        struck.map((i) => u[i] * units.ofLength),
      ),
    );
  if (clearance === null) return traces;
  const walls = [-clearance, clearance].map((wall) => wall * units.ofLength);
  traces.push(
    {
      ...line,
      yaxis: "y2",
      y: history.inCavity.map((gap) => (gap === null ? null : gap * units.ofLength)),
      name: "particle in its cavity",
      line: { color: second, width: 1.2 },
    },
    ...walls.map((wall, i) => ({
      type: "scatter",
      mode: "lines",
      x: [0, history.length],
      y: [wall, wall],
      yaxis: "y2",
      name: "walls",
      showlegend: i === 0,
      line: { color: third, width: 2, dash: "dash" },
      hoverinfo: "skip",
    })),
  );
  return traces;
}

/** @param {History} history @param {Units} units */
function timeLayout(history, units) {
  const x = { title: "cycles of the excitation", range: [0, history.length] };
  const displacement = { title: `x ${units.length}` };
  if (!history.particle) return { xaxis: x, yaxis: displacement };
  return {
    xaxis: { ...x, anchor: "y2" },
    yaxis: { ...displacement, domain: [0.52, 1] },
    yaxis2: { title: `y − x ${units.length}`, domain: [0, 0.44] },
  };
}

/** @param {History} history @param {Units} units */
function phaseTraces(history, units) {
  const [first, , third] = CURVES();
  const { u, u_rate } = history.columns;
  /** @param {number[]} values */
  const lengths = (values) => values.map((value) => value * units.ofLength);
  /** @param {number[]} values */
  const speeds = (values) => values.map((value) => value * units.ofSpeed);
  const traces = /** @type {(Trace & {x: number[], y: number[]})[]} */ ([
    {
      type: "scatter",
      mode: "lines",
      x: lengths(u),
      y: speeds(u_rate),
      name: "structure",
      line: { color: first, width: 1.2 },
    },
  ]);
  const struck = history.impacts;
  if (struck.length)
    traces.push(impactMarks(lengths(struck.map((i) => u[i])), speeds(struck.map((i) => u_rate[i]))));
  const strobes = history.strobes;
  traces.push({
    type: "scatter",
    mode: "markers",
    x: lengths(strobes.u),
    y: speeds(strobes.u_rate),
    name: "once a cycle",
    cliponaxis: false,
    marker: { symbol: "circle-open", size: 9, color: third, line: { width: 2 } },
  });
  return traces;
}

/**
 * @param {{multiple: number[], amplitude: number[]}} spectrum
 * @param {number} cycles
 * @param {number} r
 * @param {Units} units
 */
function spectrumTraces({ multiple, amplitude }, cycles, r, units) {
  const x = multiple.map((m) => m * r * units.ofFrequency);
  const floor = NOTHING * amplitude.reduce((most, value) => Math.max(most, value), 0);
  const y = amplitude.map((value) => (value > floor ? value * units.ofLength : null));
  const width = (0.7 * r * units.ofFrequency) / Math.max(1, cycles);
  return [{ type: "bar", x, y, marker: { color: CURVES()[0] }, width, name: "amplitude" }];
}

/** @param {number[]} x @param {number[]} y */
function impactMarks(x, y) {
  return {
    type: "scatter",
    mode: "markers",
    x,
    y,
    name: "impact",
    marker: { symbol: "x", size: 7, color: CURVES()[2] },
  };
}

/**
 * The curves of the forces over the cycles. A force that is always 0 is left out.
 *
 * @param {number[]} cycles
 * @param {Record<string, number[]>} forces from the service, over k·Z
 * @param {number} factor from these forces to the shown unit
 */
function forceTraces(cycles, forces, factor) {
  return FORCES.filter(([name]) => forces[name].some((force) => force !== 0)).map(([name, title], i) => ({
    type: "scatter",
    mode: "lines",
    x: cycles,
    y: forces[name].map((force) => force * factor),
    name: title,
    line: { color: CURVES()[i], dash: DASHES[i], width: 1.4 },
  }));
}
