/**
 * The quantities that a study varies, as ratios or with units, and what turns one into the other.
 *
 * @typedef {import("./axis_field.js").Quantity} Quantity
 */

import { scaled } from "./axis_field.js";
import { titled } from "./vocabulary.js";

/** The structure that ratios are turned into units with, until told otherwise: the prototype of the paper, a base of 1.5 mm. */
export const STRUCTURE = { mass_kg: 1.605, natural_frequency_hz: 2.5, base_amplitude_m: 0.0015 };

/** @type {Record<string, Quantity>} */
export const RATIOS = {
  clearance_ratio: { field: "axes.clearance_ratio", label: "", low: 0.5, high: 40, step: 0.5, usual: 5 },
  friction_ratio: { field: "axes.friction_ratio", label: "", low: 0, high: 2, step: 0.01, usual: 0.4 },
  frequency_ratio: { field: "axes.frequency_ratio", label: "", low: 0.2, high: 3, step: 0.01, usual: 1 },
  mass_ratio: { field: "axes.mass_ratio", label: "", low: 0, high: 1, step: 0.01, usual: 0.1 },
  restitution: { field: "axes.restitution", label: "", low: 0, high: 1, step: 0.01, usual: 0.47 },
  damping_ratio: { field: "damping_ratio", label: "", low: 0, high: 0.1, step: 0.0002, usual: 0.0038 },
};
for (const [name, quantity] of Object.entries(RATIOS)) quantity.label = titled(name);

/** @type {Record<string, Quantity>} */
export const PHYSICAL = {
  mass_kg: { field: "physical.mass_kg", label: "Mass of the structure M", unit: "kg", low: 0.1, high: 100, step: 0.1, usual: 1 },
  natural_frequency_hz: {
    field: "physical.natural_frequency_hz", label: "Natural frequency", unit: "Hz", low: 0.1, high: 50, step: 0.1, usual: 2.5,
  },
  base_amplitude_m: {
    field: "physical.base_amplitude_m", label: "Amplitude of the base Z", unit: "mm", scale: 1000,
    low: 0.1, high: 50, step: 0.1, usual: 1.5,
  },
  clearance_m: {
    field: "physical.clearance_m", label: "Clearance d", unit: "mm", scale: 1000, low: 0.5, high: 100, step: 0.5, usual: 7.5,
    help: "On either side of the particle: half the free cavity length.",
  },
  friction_force_n: {
    field: "physical.friction_force_n", label: "Friction force", unit: "N", low: 0, high: 2, step: 0.005, usual: 0.15,
  },
  excitation_frequency_hz: {
    field: "physical.excitation_frequency_hz", label: "Excitation frequency", unit: "Hz", low: 0.5, high: 8, step: 0.01, usual: 2.5,
  },
  particle_mass_kg: {
    field: "physical.particle_mass_kg", label: "Mass of the particle m", unit: "kg", low: 0, high: 1, step: 0.01, usual: 0.1,
  },
};

/** Which physical quantity stands for which ratio. @type {Record<string, string>} */
export const STANDS_FOR = {
  clearance_ratio: "clearance_m",
  friction_ratio: "friction_force_n",
  frequency_ratio: "excitation_frequency_hz",
  mass_ratio: "particle_mass_kg",
};

/**
 * What a ratio is multiplied with to get its physical quantity.
 *
 * @param {string} ratio
 * @param {any} physical
 * @returns {number | null} null where the structure is not given in single numbers
 */
export function unitFactor(ratio, physical) {
  const { mass_kg: mass, natural_frequency_hz: frequency, base_amplitude_m: amplitude } = physical ?? {};
  const factor = {
    clearance_ratio: amplitude,
    friction_ratio: mass * (2 * Math.PI * frequency) ** 2 * amplitude,
    frequency_ratio: frequency,
    mass_ratio: mass,
  }[ratio];
  return typeof factor === "number" && Number.isFinite(factor) && factor > 0 ? factor : null;
}

/**
 * The same study with its ratios in units.
 *
 * @param {any} study
 * @returns {any}
 */
export function inUnits(study) {
  const physical = { ...STRUCTURE, ...study.physical };
  const axes = { ...study.axes };
  for (const [ratio, name] of Object.entries(STANDS_FOR)) {
    const factor = unitFactor(ratio, physical);
    if (axes[ratio] === undefined || factor === null) continue;
    physical[name] = scaled(axes[ratio], factor);
    delete axes[ratio];
  }
  return { ...study, axes, physical };
}

/**
 * The same study as ratios alone.
 *
 * @param {any} study
 * @returns {any}
 */
export function inRatios(study) {
  const { physical = {}, ...rest } = study;
  const axes = { ...study.axes };
  for (const [ratio, name] of Object.entries(STANDS_FOR)) {
    const factor = unitFactor(ratio, physical);
    if (physical[name] !== undefined && factor !== null) axes[ratio] = scaled(physical[name], 1 / factor);
  }
  return { ...rest, axes };
}
