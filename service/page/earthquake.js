/** Compares a study's damper under an earthquake with other dampers and with no damper. */
/** @import { Earthquake, EarthquakeCase, EarthquakeHistory, Session, Tab, Trace, View } from "./types.js" */

import { Refusal, refusalBox } from "./api.js";
import { button, debounced, el, fill, grid, picker, prose, quiet, say } from "./dom.js";
import { field, showFaults } from "./faults.js";
import { colour, CURVES, Figure } from "./figure.js";
import { help } from "./help.js";
import { short } from "./numbers.js";
import { sendPatiently } from "./patience.js";
import { pythonLine } from "./python_line.js";
import { STRUCTURE, cavityOf, unitFactor } from "./quantities.js";
import { recordPicker } from "./records.js";
import { line, mm, overFrequency, overTime, SAMPLES, spectrumOf } from "./survey_motion.js";
import { TUNINGS } from "./vocabulary.js";
import { WORDS } from "./words.js";

const PATH = "earthquake-comparisons";
const COMPUTING = "Computing …";
const STARTS = 8;
const SENSITIVE =
  "Sensitive: starts that differ by a tenth of a micrometre lead to very different responses, " +
  "so one number means little. ";
const USUAL_RECORD = "el-centro";
/** Cases whose motion is drawn; curves of friction alone and of a particle alone would hide these curves. */
const MOVING = ["none", "tmd", "hybrid"];

/** Fields of the form: key in the request, label with unit, and factor to the shown unit. */
const FIELDS = /** @type {[string, string, number][]} */ ([
  ["mass_kg", "Mass of the structure [kg]", 1],
  ["natural_frequency_hz", "Natural frequency [Hz]", 1],
  ["damping_ratio", "Damping ratio ζ", 1],
  ["particle_mass_kg", "Mass of the particle [kg]", 1],
  ["clearance_m", "Clearance d [mm]", 1000],
  ["restitution", "Restitution e", 1],
  ["friction_force_n", "Friction force [N]", 1],
  ...Object.entries(WORDS.before).map(([ratio, key]) => {
    const [, label, unit, scale] = WORDS.in_units[ratio];
    return [key, unit ? `${label} [${unit}]` : label, scale];
  }),
  ["scale", "Factor on the record", 1],
]);

/** Default values of 0 for the friction of the particle and the tilt of the cavity. */
const LEVEL = Object.fromEntries(Object.values(WORDS.before).map((name) => [name, 0]));

/** @type {Tab} */
export function earthquakeTab(session, place) {
  const back = "Sizes of the study’s point";
  new Compared(session.record.id, () => sizes(session), sizesNote(session), back).drawIn(place);
}

/** @type {View} */
export async function earthquakeView(root) {
  const place = el("div");
  fill(root, el("h1", {}, "Dampers under an earthquake"), place);
  const { mass_kg, natural_frequency_hz, particle_mass_kg, clearance_m, friction_force_n } = WORDS.prototype;
  const { damping_ratio, restitution } = WORDS.design_point;
  const prototype = { mass_kg, natural_frequency_hz, particle_mass_kg, clearance_m, friction_force_n };
  const own = () => ({ ...prototype, damping_ratio, restitution });
  const note = "Sizes are those of the paper’s prototype; enter your own.";
  new Compared("prototype", own, note, "Sizes of the prototype").drawIn(place);
}

class Compared {
  number = 0;
  answer = el("div");
  fields = el("div", { class: "pairs" });
  goesOn = el("p", { class: "quiet", role: "status" }, COMPUTING);
  shown = el("div", { class: "left" }, this.goesOn);
  rest = el("div", { class: "faults" });
  place = el("div", { class: "study" });

  /**
   * @param {string} stem of downloads
   * @param {() => Record<string, number>} own function that returns the sizes with which the form begins
   * @param {string} note text about these sizes
   * @param {string} back label of the button that restores these sizes
   */
  constructor(stem, own, note, back) {
    this.own = own;
    this.note = note;
    this.back = back;
    this.asked = Object.assign(this.sizes(), {
      record: USUAL_RECORD,
      tmd_criterion: "den_hartog",
      starts: STARTS,
      scale: 1,
    });
    const drawn = (/** @type {string} */ label, /** @type {string} */ name, /** @type {number} */ height) =>
      new Figure({
        label,
        name,
        height,
        python: () => pythonLine(null, "earthquake_comparison", this.asked),
      });
    this.chart = drawn("Peak and rms displacement of the structure by damper", `earthquake-${stem}`, 340);
    this.drift = drawn("Displacement against the base over time", `earthquake-drift-${stem}`, 280);
    this.spectrum = drawn(
      "Spectrum of the displacement against the base",
      `earthquake-spectrum-${stem}`,
      260,
    );
    this.look = debounced(400, () => this.ask());
  }

  sizes() {
    return /** @type {Record<string, number>} */ ({ ...LEVEL, ...this.own() });
  }

  /** @param {HTMLElement} place */
  drawIn(place) {
    const { asked } = this;
    const again = () => (Object.assign(asked, this.sizes()), this.drawFields(), this.look());
    this.drawFields();
    fill(
      this.place,
      el("div", { class: "left" }, this.shown),
      el(
        "section",
        { class: "box point" },
        help("how-to/earthquakes/", "dampers under earthquakes"),
        el("h2", {}, "Record and sizes"),
        recordPicker(asked.record, (id) => ((asked.record = id), this.look())),
        this.fields,
        picker(
          "Mass damper tuned by",
          TUNINGS,
          asked.tmd_criterion,
          (criterion) => ((asked.tmd_criterion = criterion), this.look()),
        ),
        quiet(this.note),
        button(this.back, again),
        this.rest,
      ),
    );
    fill(place, this.place);
    this.look();
  }

  drawFields() {
    fill(
      this.fields,
      FIELDS.map(([key, label, scale]) => this.field(key, label, scale)),
    );
  }

  /** @param {string} key @param {string} label @param {number} scale */
  field(key, label, scale) {
    const { asked } = this;
    const value = Number((asked[key] * scale).toPrecision(6));
    const oninput = () => {
      // an empty box gives null, which the service reports as a fault
      asked[key] = /** @type {number} */ (box.value === "" ? null : Number(box.value) / scale);
      this.look();
    };
    const box = el("input", { type: "number", step: "any", value, oninput });
    return field(key, label, box, { unit: "mm", scale });
  }

  async ask() {
    const mine = ++this.number;
    const { asked, place, rest } = this;
    const late = () => mine !== this.number;
    try {
      const tell = (/** @type {string} */ words) => fill(this.goesOn, words || COMPUTING);
      const found = await sendPatiently(PATH, asked, tell);
      if (late()) return;
      showFaults(place, [], rest);
      await this.draw(found);
      const moving = { ...asked, cases: MOVING, starts: 0 };
      const moved = await sendPatiently(PATH, moving, () => undefined, undefined, { samples: SAMPLES });
      if (!late() && this.shown.isConnected) await this.drawMotion(moved);
    } catch (error) {
      if (late()) return;
      if (error instanceof Refusal && error.faults.length) showFaults(place, error.faults, rest);
      else fill(this.shown, refusalBox(error));
    }
  }

  /** @param {Earthquake} found */
  async draw(found) {
    const { chart, drift, spectrum, answer } = this;
    if (!chart.element.isConnected) fill(this.shown, chart.element, answer, drift.element, spectrum.element);
    fill(answer, table(found));
    await chart.draw(
      () => traces(found),
      () => ({
        barmode: "group",
        xaxis: { title: "", tickangle: 0 },
        yaxis: { title: "displacement against the base [mm]", rangemode: "tozero" },
      }),
    );
    say(`Compared under ${found.record.name}.`);
  }

  /** @param {Earthquake} moved */
  async drawMotion(moved) {
    await this.drift.draw(
      () =>
        moving(moved, (history, name, shade, dash) =>
          line(history, mm(history.relative_displacement_m), name, shade, dash),
        ),
      () => overTime("x − z [mm]"),
    );
    await this.spectrum.draw(() => moving(moved, spectrumOf), overFrequency);
  }
}

/**
 * The point of the study in units. The paper's prototype supplies missing values of the structure.
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
 * The curves of the motion without a damper, with a tuned mass damper, and with the study's damper.
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
