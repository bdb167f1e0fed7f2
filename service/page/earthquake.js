/**
 * Dampers under an earthquake: the point of the study beside no damper, a tuned mass damper, and each of its
 * parts alone.
 */
/** @import { Earthquake, EarthquakeCase, EarthquakeHistory, Session, Tab, Trace, View } from "./types.js" */

import { Refusal, refusalBox } from "./api.js";
import { debounced, el, fill, grid, picker, prose, say } from "./dom.js";
import { field, showFaults } from "./faults.js";
import { colour, CURVES, figure } from "./figure.js";
import { help } from "./help.js";
import { short } from "./numbers.js";
import { sendPatiently } from "./patience.js";
import { pythonLine } from "./python_line.js";
import { STRUCTURE, cavityOf, unitFactor } from "./quantities.js";
import { recordPicker } from "./records.js";
import { line, mm, SAMPLES, spectrumOf } from "./survey_motion.js";
import { TUNINGS } from "./vocabulary.js";
import { WORDS } from "./words.js";

const STARTS = 8;
const SENSITIVE =
  "Sensitive: a start that differs by a tenth of a micrometre ends far away, so one number means little. ";
const USUAL_RECORD = "el-centro";
/** Cases whose motion is drawn; each part of the damper alone would hide the others. */
const MOVING = ["none", "tmd", "hybrid"];

/**
 * What is asked for: the key of the request, its label and unit, and what turns metres into what is shown.
 */
const FIELDS = /** @type {[string, string, number][]} */ ([
  ["mass_kg", "Mass of the structure [kg]", 1],
  ["natural_frequency_hz", "Natural frequency [Hz]", 1],
  ["damping_ratio", "Damping ratio ζ", 1],
  ["particle_mass_kg", "Mass of the particle [kg]", 1],
  ["clearance_m", "Clearance d [mm]", 1000],
  ["restitution", "Restitution e", 1],
  ["friction_force_n", "Friction force [N]", 1],
  ["particle_friction_coefficient", "Friction coefficient of the particle μ_i", 1],
  ["tilt_deg", "Tilt of the cavity [°]", 1],
  ["scale", "Factor on the record", 1],
]);

/** A cavity of which nothing is said. */
const LEVEL = Object.fromEntries(Object.values(WORDS.before).map((name) => [name, 0]));

/** @type {Tab} */
export function earthquakeTab(session, place) {
  compared(place, session.record.id, () => sizes(session), sizesNote(session), "Sizes of the study’s point");
}

/** @type {View} */
export async function earthquakeView(root) {
  const place = el("div");
  fill(root, el("h1", {}, "Dampers under an earthquake"), place);
  const { mass_kg, natural_frequency_hz, particle_mass_kg, clearance_m, friction_force_n } = WORDS.prototype;
  const { damping_ratio, restitution } = WORDS.design_point;
  const prototype = { mass_kg, natural_frequency_hz, particle_mass_kg, clearance_m, friction_force_n };
  const note = "Sizes are those of the paper’s prototype; enter your own.";
  compared(
    place,
    "prototype",
    () => ({ ...prototype, damping_ratio, restitution }),
    note,
    "Sizes of the prototype",
  );
}

/**
 * @param {HTMLElement} place
 * @param {string} stem of downloads
 * @param {() => Record<string, number>} own the sizes that it begins with
 * @param {string} note about them
 * @param {string} back what the button says that takes them again
 */
function compared(place, stem, own, note, back) {
  const sizes = /** @type {Record<string, number>} */ ({ ...LEVEL, ...own() });
  const asked = Object.assign(sizes, {
    record: USUAL_RECORD,
    tmd_criterion: "den_hartog",
    starts: STARTS,
    scale: 1,
  });
  const answer = el("div");
  const same = () => pythonLine(null, "earthquake_comparison", asked);
  const chart = figure({
    label: "Peak and rms displacement of the structure by damper",
    name: `earthquake-${stem}`,
    height: 340,
    python: same,
  });
  const drift = figure({
    label: "Displacement against the base over time",
    name: `earthquake-drift-${stem}`,
    height: 280,
    python: same,
  });
  const spectrum = figure({
    label: "Spectrum of the displacement against the base",
    name: `earthquake-spectrum-${stem}`,
    height: 260,
    python: same,
  });
  const fields = el("div", { class: "pairs" });
  const goesOn = el("p", { class: "quiet", role: "status" }, "Computing …");
  const shown = el("div", { class: "left" }, goesOn);
  const rest = el("div", { class: "faults" });
  let number = 0;

  const look = debounced(400, async () => {
    const mine = ++number;
    try {
      const found = await sendPatiently("earthquake-comparisons", asked, (words) =>
        fill(goesOn, words || "Computing …"),
      );
      if (mine !== number) return;
      showFaults(place, [], rest);
      if (!chart.element.isConnected) fill(shown, chart.element, answer, drift.element, spectrum.element);
      fill(answer, table(found));
      await chart.draw(
        () => traces(found),
        () => ({
          barmode: "group",
          xaxis: { title: { text: "" }, tickangle: 0 },
          yaxis: { title: { text: "displacement against the base [mm]" }, rangemode: "tozero" },
        }),
      );
      say(`Compared under ${found.record.name}.`);
      const moved = await sendPatiently(
        "earthquake-comparisons",
        { ...asked, cases: MOVING, starts: 0 },
        () => undefined,
        undefined,
        { samples: SAMPLES },
      );
      if (mine !== number || !shown.isConnected) return;
      await drift.draw(
        () =>
          moving(moved, (history, name, shade, dash) =>
            line(history, mm(history.relative_displacement_m), name, shade, dash),
          ),
        () => ({ xaxis: { title: { text: "time [s]" } }, yaxis: { title: { text: "x − z [mm]" } } }),
      );
      await spectrum.draw(
        () => moving(moved, (history, name, shade, dash) => spectrumOf(history, name, shade, dash)),
        () => ({
          xaxis: { title: { text: "frequency [Hz]" } },
          yaxis: { title: { text: "amplitude of x − z [mm]" }, rangemode: "tozero" },
        }),
      );
    } catch (error) {
      if (mine !== number) return;
      if (error instanceof Refusal && error.faults.length) showFaults(place, error.faults, rest);
      else fill(shown, refusalBox(error));
    }
  });

  function drawFields() {
    fill(
      fields,
      FIELDS.map(([key, label, scale]) => {
        const box = el("input", {
          type: "number",
          step: "any",
          value: Number((asked[key] * scale).toPrecision(6)),
          oninput: () => {
            asked[key] = /** @type {number} */ (box.value === "" ? null : Number(box.value) / scale);
            look();
          },
        });
        return field(key, label, box, { unit: "mm", scale });
      }),
    );
  }

  const again = el(
    "button",
    { type: "button", onclick: () => (Object.assign(asked, LEVEL, own()), drawFields(), look()) },
    back,
  );
  drawFields();
  fill(
    place,
    el(
      "div",
      { class: "study" },
      el("div", { class: "left" }, shown),
      el(
        "section",
        { class: "box point" },
        help("how-to/earthquakes/", "dampers under earthquakes"),
        el("h2", {}, "Record and sizes"),
        recordPicker(asked.record, (id) => ((asked.record = id), look())),
        fields,
        picker(
          "Mass damper tuned by",
          TUNINGS,
          asked.tmd_criterion,
          (criterion) => ((asked.tmd_criterion = criterion), look()),
        ),
        el("p", { class: "quiet" }, note),
        again,
        rest,
      ),
    ),
  );
  look();
}

/**
 * The point of the study with units: of its own structure where it has one, else of the paper's.
 *
 * @param {Session} session
 */
function sizes({ selection, record }) {
  const physical = { ...STRUCTURE, ...numbersIn(record.definition.physical) };
  const of = (/** @type {string} */ ratio) => selection.value(ratio) * (unitFactor(ratio, physical) ?? 0);
  const particle = record.definition.particle !== false;
  return {
    mass_kg: physical.mass_kg,
    natural_frequency_hz: physical.natural_frequency_hz,
    damping_ratio: selection.value("damping_ratio"),
    friction_force_n: of("friction_ratio"),
    particle_mass_kg: particle ? of("mass_ratio") : 0,
    clearance_m: particle ? of("clearance_ratio") : STRUCTURE.base_amplitude_m,
    restitution: particle ? selection.value("restitution") : 0,
    ...(particle ? cavityOf(record, (ratio) => selection.value(ratio), physical) : {}),
  };
}

/** @param {unknown} physical @returns {Record<string, number>} */
function numbersIn(physical) {
  return Object.fromEntries(
    Object.entries(physical ?? {}).filter(([name, value]) => name in STRUCTURE && typeof value === "number"),
  );
}

/** @param {Session} session */
function sizesNote({ record }) {
  const own = Object.keys(numbersIn(record.definition.physical)).length === Object.keys(STRUCTURE).length;
  return own
    ? "Sizes are those of the study."
    : `The study is given in ratios only. Its point is converted to sizes with ${STRUCTURE.mass_kg} kg, ` +
        `${STRUCTURE.natural_frequency_hz} Hz and a base amplitude of ${1000 * STRUCTURE.base_amplitude_m} ` +
        "mm; enter your own.";
}

/** @param {Earthquake} found */
function table(found) {
  const columns = /** @type {[string, string][]} */ ([
    ["peak_relative_displacement_m", "Peak [mm]"],
    ["rms_relative_displacement_m", "rms [mm]"],
    ["peak_absolute_acceleration_m_s2", "Peak acceleration [m/s²]"],
  ]);
  const cases = Object.values(found.cases);
  const value = (/** @type {EarthquakeCase} */ one, /** @type {string} */ name) =>
    short(one[name] * (name.endsWith("_m") ? 1000 : 1), 4);
  const span = (/** @type {EarthquakeCase} */ one) => {
    if (!one.spread) return "–";
    const { peak_relative_displacement_m: peak, sensitive } = one.spread;
    const [lowest, highest] = [peak.lowest, peak.highest].map((metres) => short(1000 * metres, 4));
    return `${lowest} to ${highest}${sensitive ? ", sensitive" : ""}`;
  };
  return [
    el(
      "div",
      { class: "box" },
      grid(
        "Comparison under the record",
        ["Damper", ...columns.map(([, title]) => title), "Peak from other starts [mm]"],
        cases.map((one) => [one.label, ...columns.map(([name]) => value(one, name)), span(one)]),
      ),
    ),
    el(
      "p",
      { class: "quiet note" },
      prose(
        `Displacements are against the base. ${found.record.name}: peak ` +
          `${short(found.record.peak_acceleration_g, 3)} g, ${short(found.record.duration_s, 4)} s. ` +
          (cases.some((one) => one.spread?.sensitive) ? SENSITIVE : "") +
          (found.note ?? ""),
      ),
    ),
  ];
}

/** @param {Earthquake} found */
function traces(found) {
  const cases = Object.values(found.cases);
  const bar = (/** @type {string} */ name, /** @type {string} */ title, /** @type {number} */ i) => ({
    type: "bar",
    name: title,
    x: cases.map((one) => one.label.replaceAll(" ", "<br>")),
    y: cases.map((one) => 1000 * one[name]),
    marker: { color: CURVES()[i], pattern: { shape: ["", "/"][i] } },
    hovertemplate: "%{y:.4~g} mm",
  });
  return [bar("peak_relative_displacement_m", "peak", 0), bar("rms_relative_displacement_m", "rms", 1)];
}

/**
 * The motion of no damper, a tuned mass damper and the study's, each as a curve.
 *
 * @param {Earthquake} found
 * @param {(history: EarthquakeHistory, name: string, shade: string, dash: string) => Trace} drawn
 */
function moving(found, drawn) {
  const looks = [
    [colour("quiet"), "dot"],
    [CURVES()[0], "dash"],
    [CURVES()[1], "solid"],
  ];
  return MOVING.flatMap((name, i) => {
    const history = found.histories[name];
    return history ? [drawn(history, found.cases[name].label, looks[i][0], looks[i][1])] : [];
  });
}
