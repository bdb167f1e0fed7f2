/**
 * The quantities that a study varies, as ratios and in units, and the conversion between ratios and units.
 *
 * @typedef {Record<string, unknown>} Physical
 */
/** @import { Definition, Quantity, Spec, StudyRecord } from "./types.js" */

import { scaled } from "./axis_field.js";
import { titled } from "./vocabulary.js";
import { WORDS } from "./words.js";

/** The default structure for the conversion of ratios into units: the prototype of the paper. */
export const STRUCTURE = WORDS.structure;

/** Form fields of ratios. Each field begins with the default of the service. */
export const RATIOS = fields("axes", WORDS.design_point, {
  clearance_ratio: { low: 0.5, high: 40, step: 0.5 },
  friction_ratio: { low: 0, high: 2, step: 0.01 },
  frequency_ratio: { low: 0.2, high: 3, step: 0.01 },
  mass_ratio: { low: 0, high: 1, step: 0.01 },
  restitution: { low: 0, high: 1, step: 0.01 },
  damping_ratio: { field: "damping_ratio", low: 0, high: 0.1, step: 0.0002 },
});

/** Form fields of physical quantities. Each field begins with the value of the paper's prototype. */
export const PHYSICAL = fields("physical", WORDS.prototype, {
  mass_kg: { label: "Mass of the structure M", unit: "kg", low: 0.1, high: 100, step: 0.1 },
  natural_frequency_hz: { label: "Natural frequency", unit: "Hz", low: 0.1, high: 50, step: 0.1 },
  base_amplitude_m: {
    label: "Amplitude of the base Z",
    unit: "mm",
    scale: 1000,
    low: 0.1,
    high: 50,
    step: 0.1,
  },
  clearance_m: {
    label: "Clearance d",
    unit: "mm",
    scale: 1000,
    low: 0.5,
    high: 100,
    step: 0.5,
    help: "On either side of the particle: half the free cavity length.",
  },
  friction_force_n: { label: "Friction force", unit: "N", low: 0, high: 2, step: 0.005 },
  excitation_frequency_hz: { label: "Excitation frequency", unit: "Hz", low: 0.5, high: 8, step: 0.01 },
  particle_mass_kg: { label: "Mass of the particle m", unit: "kg", low: 0, high: 1, step: 0.01 },
});

/**
 * @param {string} section section of the quantities in the JSON of a study
 * @param {Record<string, number>} begins
 * @param {Record<string, Partial<Quantity> & {low: number, high: number, step: number}>} looks
 * @returns {Record<string, Quantity>}
 */
function fields(section, begins, looks) {
  const whole = Object.entries(looks).map(([name, look]) => [
    name,
    { field: `${section}.${name}`, label: titled(name), usual: begins[name] * (look.scale ?? 1), ...look },
  ]);
  return Object.fromEntries(whole);
}

/** The physical quantity that corresponds to each ratio, for quantities with a field in `PHYSICAL`. */
export const STANDS_FOR = Object.fromEntries(
  Object.entries(WORDS.stands_for).filter(([, name]) => name in PHYSICAL),
);

/** The values by which ratios are defined; NaN for missing values. @param {Physical | undefined} physical */
function structureOf(physical) {
  const [mass, frequency, amplitude] = ["mass_kg", "natural_frequency_hz", "base_amplitude_m"].map((name) =>
    typeof physical?.[name] === "number" ? physical[name] : NaN,
  );
  return { mass, frequency, amplitude, acceleration: (2 * Math.PI * frequency) ** 2 * amplitude };
}

/**
 * The factor that converts a ratio into the corresponding physical quantity.
 *
 * @param {string} ratio
 * @param {Physical | undefined} physical
 * @returns {number | null} null if a value of the structure is missing or is a range
 */
export function unitFactor(ratio, physical) {
  const { mass, frequency, amplitude, acceleration } = structureOf(physical);
  const factor = {
    clearance_ratio: amplitude,
    friction_ratio: mass * acceleration,
    frequency_ratio: frequency,
    mass_ratio: mass,
  }[ratio];
  return factor && Number.isFinite(factor) && factor > 0 ? factor : null;
}

const BEGINNING_DIGITS = 3;
/** Standard gravity [m/s²]. */
const STANDARD_GRAVITY = 9.80665;

/**
 * Tilt of the cavity and friction coefficient of the particle at the selected point, named as in `physical`.
 *
 * @param {StudyRecord} record record of the study
 * @param {(ratio: string) => number} value function that returns a ratio of the selected point
 * @param {Physical} physical single values of the structure
 */
export function cavityOf({ definition, dimensions }, value, physical) {
  const { particle_friction_coefficient: friction, tilt_deg: angle } = definition.physical ?? {};
  const of = (/** @type {string} */ ratio) =>
    dimensions.includes(ratio) ? value(ratio) / weightOf(physical) : 0;
  // if the tilt is an axis, the tilt of the point follows from its gravity ratio
  const tilt =
    typeof angle === "number" ? angle : (Math.asin(Math.min(1, of("gravity_ratio"))) * 180) / Math.PI;
  const lying = tilt === 90 ? 0 : Math.cos((tilt * Math.PI) / 180);
  const rubs = dimensions.includes("particle_friction_ratio")
    ? lying && of("particle_friction_ratio") / lying
    : Number(friction ?? 0);
  return { particle_friction_coefficient: Number(rubs.toPrecision(12)), tilt_deg: tilt };
}

/** The ratio of standard gravity to Z·ω_n². @param {Physical} physical */
function weightOf(physical) {
  return STANDARD_GRAVITY / structureOf(physical).acceleration;
}

/**
 * The study with ratios converted to units. If the study gives no structure, the values are rounded.
 *
 * @param {Definition} study
 * @returns {Definition}
 */
export function inUnits(study) {
  /** @type {Record<string, Spec>} */
  const physical = { ...STRUCTURE, ...study.physical };
  const axes = { ...study.axes };
  for (const [ratio, name] of Object.entries(STANDS_FOR)) {
    const factor = unitFactor(ratio, physical);
    if (axes[ratio] === undefined || factor === null) continue;
    physical[name] = scaled(axes[ratio], factor, study.physical ? undefined : BEGINNING_DIGITS);
    delete axes[ratio];
  }
  return { ...study, axes, physical };
}

/**
 * The study with all quantities converted to ratios. If the tilt is a range, the study is unchanged, because
 * no range of ratios corresponds to a range of tilts.
 *
 * @param {Definition} study
 * @returns {Definition}
 */
export function inRatios(study) {
  const { physical = {}, ...rest } = study;
  const axes = { ...study.axes };
  const { tilt_deg: tilt = 0 } = physical;
  if (typeof tilt !== "number") return study;
  const weight = weightOf(physical);
  const angle = (tilt * Math.PI) / 180;
  if (physical.particle_friction_coefficient !== undefined) {
    rest.particle_friction_ratio = scaled(
      physical.particle_friction_coefficient,
      tilt === 90 ? 0 : weight * Math.cos(angle),
    );
  }
  if (tilt) rest.gravity_ratio = weight * Math.sin(angle);
  for (const [ratio, name] of Object.entries(STANDS_FOR)) {
    const factor = unitFactor(ratio, physical);
    if (physical[name] !== undefined && factor !== null) axes[ratio] = scaled(physical[name], 1 / factor);
  }
  return { ...rest, axes };
}
