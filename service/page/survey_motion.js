/** The motion of one case of a ground-motion suite, with spectrum and energies. */
/** @import { Earthquake, EarthquakeCase, EarthquakeHistory, Session } from "./types.js" */

import { refusalBox } from "./api.js";
import { debounced, el, facts, fill, picker, quiet } from "./dom.js";
import { colour, CURVES, Figure } from "./figure.js";
import { drawn, short } from "./numbers.js";
import { sendPatiently } from "./patience.js";
import { pythonLine } from "./python_line.js";
import { RECORD } from "./selection.js";
import { WORDS } from "./words.js";

export const SAMPLES = 6000;
const COMPUTING = "Computing the motion …";
const AXES = [
  "natural_frequency_hz",
  "damping_ratio",
  "scale",
  "restitution",
  "particle_mass_kg",
  "clearance_m",
  "friction_force_n",
];
const ENERGIES = /** @type {[string, string][]} */ ([
  ["work_in_j", "Work of the base"],
  ["loss_viscous_j", "Lost to damping of the structure"],
  ["loss_friction_j", "Lost to friction"],
  ["loss_impact_j", "Lost in impacts"],
]);

export class SurveyMotion {
  number = 0;
  goesOn = el("p", { class: "quiet", role: "status" });
  shown = el("div");
  which = el("div", { class: "row controls" });

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    this.drift = this.figure("Drift of the structure under the record", "drift", 280);
    this.both = this.figure("Base and structure under the record", "base", 240);
    this.cavity = this.figure("Particle in its cavity under the record", "cavity", 240);
    this.spectrum = this.figure("Spectrum of the drift", "spectrum", 260);
    this.element = el(
      "section",
      { class: "box motion", "aria-label": "Motion of one case" },
      el("h2", {}, "Motion of one case"),
      this.which,
      this.goesOn,
      this.shown,
    );
    this.look = debounced(250, () => this.ask());
    session.selection.addEventListener("chosen", () => this.element.isConnected && this.look());
  }

  /** @param {string} label @param {string} stem @param {number} height */
  figure(label, stem, height) {
    const python = () => pythonLine(null, "earthquake_comparison", this.question());
    return new Figure({ label, name: `${stem}-${this.session.record.id}`, height, python });
  }

  drawPickers() {
    const { selection } = this.session;
    const { records } = selection;
    const { scale: scales } = selection.axes;
    const choose = (/** @type {string} */ name) => (/** @type {string} */ value) =>
      selection.chooseValues({ [name]: value });
    /** @param {string[]} values @param {string[]} texts @returns {[string, string][]} */
    const options = (values, texts) => values.map((value, i) => [value, texts[i]]);
    fill(
      this.which,
      picker("Motion under", options(records, records), String(selection.value(RECORD)), choose(RECORD)),
      scales.length > 1 &&
        picker(
          "times",
          options(
            scales.map(String),
            scales.map((one) => short(one)),
          ),
          String(selection.value("scale")),
          choose("scale"),
        ),
    );
  }

  /** The request for the motion of the case. */
  question() {
    const { selection, record } = this.session;
    const { mass_kg, tail_s, contact } = record.definition;
    const cavity = Object.values(WORDS.before).filter((name) => name in record.definition);
    return {
      ...Object.fromEntries(AXES.map((name) => [name, selection.value(name)])),
      mass_kg,
      tail_s,
      ...(contact ? { contact } : {}),
      ...Object.fromEntries(cavity.map((name) => [name, record.definition[name]])),
      record: selection.value(RECORD),
      cases: ["none", "hybrid"],
      starts: 0,
    };
  }

  async ask() {
    const mine = ++this.number;
    this.drawPickers();
    fill(this.goesOn, COMPUTING);
    try {
      const tell = (/** @type {string} */ words) =>
        mine === this.number && fill(this.goesOn, words || COMPUTING);
      const path = "earthquake-comparisons";
      const answer = await sendPatiently(path, this.question(), tell, undefined, { samples: SAMPLES });
      if (mine === this.number && this.element.isConnected) await this.draw(answer);
    } catch (error) {
      if (mine === this.number) (fill(this.goesOn), fill(this.shown, refusalBox(error)));
    }
  }

  /** @param {Earthquake} answer */
  async draw({ histories: { hybrid, none }, cases }) {
    const { drift, both, cavity, spectrum } = this;
    const { selection } = this.session;
    const particle = selection.value("particle_mass_kg") > 0;
    const thinned = `The motion is thinned to ${hybrid.time_s.length} samples; its peaks are among them.`;
    fill(this.goesOn, hybrid.thinned ? thinned : "");
    const figures = [drift, both, ...(particle ? [cavity] : []), spectrum];
    fill(
      this.shown,
      figures.map(({ element }) => element),
      energies(cases.hybrid),
    );
    await drift.draw(
      () => [
        line(none, mm(none.relative_displacement_m), "no damper", colour("quiet"), "dot"),
        line(hybrid, mm(hybrid.relative_displacement_m), "this damper", CURVES()[1]),
      ],
      () => overTime("x − z [mm]"),
    );
    await both.draw(
      () => baseTraces(hybrid),
      () => overTime("x, z [mm]"),
    );
    if (particle)
      await cavity.draw(
        () => cavityTraces(hybrid, selection.value("clearance_m")),
        () => overTime("y − x [mm]"),
      );
    await spectrum.draw(
      () => [
        spectrumOf(none, "no damper", colour("quiet"), "dot"),
        spectrumOf(hybrid, "this damper", CURVES()[1]),
      ],
      overFrequency,
    );
  }
}

/** @param {string} title title of the quantity that is shown over time */
export function overTime(title) {
  return { xaxis: { title: "time [s]" }, yaxis: { title: title } };
}

/** The layout of a spectrum of the drift. */
export function overFrequency() {
  return {
    xaxis: { title: "frequency [Hz]" },
    yaxis: { title: "amplitude of x − z [mm]", rangemode: "tozero" },
  };
}

/** @param {EarthquakeHistory} history */
function baseTraces(history) {
  const { absolute_displacement_m: absolute, relative_displacement_m: relative } = history;
  const base = absolute.map((x, i) => x - relative[i]);
  return [
    line(history, mm(base), "base z", colour("quiet"), "dot"),
    line(history, mm(absolute), "structure x", CURVES()[0]),
  ];
}

/** @param {number[]} metres */
export function mm(metres) {
  return metres.map((value) => 1000 * value);
}

/**
 * @param {EarthquakeHistory} history
 * @param {(number | null)[]} y
 * @param {string} name
 * @param {string} shade
 * @param {string} [dash]
 */
export function line(history, y, name, shade, dash = "solid") {
  return {
    type: "scatter",
    mode: "lines",
    name,
    x: history.time_s,
    y,
    line: { color: shade, dash, width: 1.2 },
    hovertemplate: `%{x:.3f} s: %{y:.4~g} mm<extra>${name}</extra>`,
  };
}

/**
 * The curve of the particle's position relative to the middle of its cavity, and the lines of the two walls.
 *
 * @param {EarthquakeHistory} history
 * @param {number} clearance
 */
function cavityTraces(history, clearance) {
  const gap = history.particle_displacement_m.map((p, i) =>
    p === null ? null : 1000 * (p - history.absolute_displacement_m[i]),
  );
  const ends = [history.time_s[0], history.time_s[history.time_s.length - 1]];
  const wall = (/** @type {number} */ side) => ({
    type: "scatter",
    mode: "lines",
    name: "walls",
    x: ends,
    y: [side, side].map((one) => 1000 * clearance * one),
    line: { color: colour("ink"), width: 2 },
    hoverinfo: "skip",
    showlegend: side > 0,
  });
  return [line(history, gap, "particle", CURVES()[2]), wall(1), wall(-1)];
}

/**
 * The curve of the amplitude of the drift over the frequency.
 *
 * @param {EarthquakeHistory} history
 * @param {string} name
 * @param {string} shade
 * @param {string} [dash]
 */
export function spectrumOf({ spectrum }, name, shade, dash = "solid") {
  return {
    type: "scatter",
    mode: "lines",
    name,
    x: spectrum.frequency_hz,
    y: mm(spectrum.amplitude_m),
    line: { color: shade, dash, width: 1.2 },
    hovertemplate: `%{x:.3f} Hz: %{y:.4~g} mm<extra>${name}</extra>`,
  };
}

/** @param {EarthquakeCase} found */
function energies(found) {
  const lost = ENERGIES.slice(1).reduce((sum, [name]) => sum + found[name], 0);
  const share = (/** @type {string} */ name) =>
    name !== "work_in_j" && lost > 0 ? `, ${short((100 * found[name]) / lost, 3)} % of the losses` : "";
  return [
    el("h3", {}, "Energies"),
    facts(ENERGIES.map(([name, words]) => [words, `${short(found[name], 4)} J${share(name)}`])),
    quiet(
      `Largest drift ${drawn(found.peak_relative_displacement_m, "m", 4)}, largest acceleration ` +
        `${short(found.peak_absolute_acceleration_m_s2, 4)} m/s², ${found.impacts} impacts, the fastest ` +
        `at ${short(found.impact_speed_max_m_s, 3)} m/s.`,
    ),
  ];
}
