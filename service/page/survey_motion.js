/**
 * The motion of one case of a survey: drift, base and structure, the particle in its cavity, spectrum,
 * energies.
 */
/** @import { EarthquakeCase, EarthquakeHistory, Session } from "./types.js" */

import { refusalBox } from "./api.js";
import { debounced, el, fill, picker } from "./dom.js";
import { colour, CURVES, figure } from "./figure.js";
import { drawn, short } from "./numbers.js";
import { sendPatiently } from "./patience.js";
import { pythonLine } from "./python_line.js";
import { RECORD } from "./selection.js";
import { WORDS } from "./words.js";

export const SAMPLES = 6000;
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

/** @param {Session} session */
export function surveyMotion({ selection, record }) {
  const id = record.id;
  const same = () => pythonLine(null, "earthquake_comparison", question());
  const drift = figure({
    label: "Drift of the structure under the record",
    name: `drift-${id}`,
    height: 280,
    python: same,
  });
  const both = figure({
    label: "Base and structure under the record",
    name: `base-${id}`,
    height: 240,
    python: same,
  });
  const cavity = figure({
    label: "Particle in its cavity under the record",
    name: `cavity-${id}`,
    height: 240,
    python: same,
  });
  const spectrum = figure({
    label: "Spectrum of the drift",
    name: `spectrum-${id}`,
    height: 260,
    python: same,
  });
  const goesOn = el("p", { class: "quiet", role: "status" });
  const shown = el("div");
  const which = el("div", { class: "row controls" });
  const element = el(
    "section",
    { class: "box motion", "aria-label": "Motion of one case" },
    el("h2", {}, "Motion of one case"),
    which,
    goesOn,
    shown,
  );
  let number = 0;

  function drawPickers() {
    const scales = selection.axes.scale;
    fill(
      which,
      picker(
        "Motion under",
        selection.records.map((one) => [one, one]),
        String(selection.value(RECORD)),
        (one) => selection.chooseValues({ [RECORD]: one }),
      ),
      scales.length > 1 &&
        picker(
          "times",
          scales.map((one) => [String(one), short(one)]),
          String(selection.value("scale")),
          (one) => selection.chooseValues({ scale: one }),
        ),
    );
  }

  /** The case as a request. */
  function question() {
    const { mass_kg, tail_s, contact } = record.definition;
    const cavity = Object.values(WORDS.before).filter((name) => name in record.definition);
    const point = Object.fromEntries(AXES.map((name) => [name, selection.value(name)]));
    return {
      ...point,
      mass_kg,
      tail_s,
      ...(contact ? { contact } : {}),
      ...Object.fromEntries(cavity.map((name) => [name, record.definition[name]])),
      record: selection.value(RECORD),
      cases: ["none", "hybrid"],
      starts: 0,
    };
  }

  const look = debounced(250, async () => {
    const mine = ++number;
    drawPickers();
    fill(goesOn, "Computing the motion …");
    try {
      const answer = await sendPatiently(
        "earthquake-comparisons",
        question(),
        (words) => mine === number && fill(goesOn, words || "Computing the motion …"),
        undefined,
        { samples: SAMPLES },
      );
      if (mine !== number || !element.isConnected) return;
      const { hybrid, none } = answer.histories;
      const particle = selection.value("particle_mass_kg") > 0;
      fill(
        goesOn,
        hybrid.thinned
          ? `The motion is thinned to ${hybrid.time_s.length} samples; its peaks are among them.`
          : "",
      );
      fill(
        shown,
        drift.element,
        both.element,
        particle && cavity.element,
        spectrum.element,
        energies(answer.cases.hybrid),
      );
      const time = { title: { text: "time [s]" } };
      await drift.draw(
        () => [
          line(none, mm(none.relative_displacement_m), "no damper", colour("quiet"), "dot"),
          line(hybrid, mm(hybrid.relative_displacement_m), "this damper", CURVES()[1]),
        ],
        () => ({ xaxis: time, yaxis: { title: { text: "x − z [mm]" } } }),
      );
      const base = hybrid.absolute_displacement_m.map((x, i) => x - hybrid.relative_displacement_m[i]);
      await both.draw(
        () => [
          line(hybrid, mm(base), "base z", colour("quiet"), "dot"),
          line(hybrid, mm(hybrid.absolute_displacement_m), "structure x", CURVES()[0]),
        ],
        () => ({ xaxis: time, yaxis: { title: { text: "x, z [mm]" } } }),
      );
      if (particle)
        await cavity.draw(
          () => cavityTraces(hybrid, selection.value("clearance_m")),
          () => ({ xaxis: time, yaxis: { title: { text: "y − x [mm]" } } }),
        );
      await spectrum.draw(
        () => [
          spectrumOf(none, "no damper", colour("quiet"), "dot"),
          spectrumOf(hybrid, "this damper", CURVES()[1]),
        ],
        () => ({
          xaxis: { title: { text: "frequency [Hz]" } },
          yaxis: { title: { text: "amplitude of x − z [mm]" }, rangemode: "tozero" },
        }),
      );
    } catch (error) {
      if (mine === number) (fill(goesOn), fill(shown, refusalBox(error)));
    }
  });

  selection.addEventListener("chosen", () => element.isConnected && look());
  return { element, look };
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
 * Where the particle is against the middle of its cavity, and the walls.
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
 * Amplitudes of the drift over the frequency.
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
    name !== "work_in_j" && lost > 0 ? `, ${short((100 * found[name]) / lost, 3)} % of what is lost` : "";
  return [
    el("h3", {}, "Energies"),
    el(
      "dl",
      { class: "facts" },
      ENERGIES.map(([name, words]) =>
        el("div", {}, el("dt", {}, words), el("dd", {}, `${short(found[name], 4)} J${share(name)}`)),
      ),
    ),
    el(
      "p",
      { class: "quiet" },
      `Largest drift ${drawn(found.peak_relative_displacement_m, "m", 4)}, largest acceleration ` +
        `${short(found.peak_absolute_acceleration_m_s2, 4)} m/s², ${found.impacts} impacts, the fastest ` +
        `at ${short(found.impact_speed_max_m_s, 3)} m/s.`,
    ),
  ];
}
