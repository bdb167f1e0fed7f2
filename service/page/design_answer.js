/** What an answer of a design is about. */
/** @import { DesignAnswer, Worst } from "./types.js" */

import { WORDS } from "./words.js";

/**
 * Whether nothing was to be chosen: the answer is about the damper of the specification.
 *
 * @param {DesignAnswer} answer
 */
export function given(answer) {
  return !Object.keys(answer.specification.choose ?? {}).length;
}

/**
 * Whether another damper is the one that the answer is about: without a particle it is friction alone.
 *
 * @param {DesignAnswer} answer
 * @param {string} name
 */
export function isItself({ design }, name) {
  const mass = design.particle_mass_kg ?? design.mass_ratio;
  const friction = design.friction_force_n ?? design.friction_ratio;
  return (name === "friction_alone" && mass === 0) || (name === "particle_alone" && friction === 0);
}

/**
 * Whether the rms over the band is judged, which is at no frequency.
 *
 * @param {Worst} worst
 */
export function isMean(worst) {
  return worst.measure in WORDS.specification.tables.at_a_frequency;
}
