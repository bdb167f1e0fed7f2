/**
 * Forces on the structure over a computed motion, over k·Z: what excites it, the spring, the damping and
 * friction.
 */

import { CURVES, DASHES } from "./figure.js";

/** Of the largest speed: a structure that is slower is held by friction. */
const HELD = 1e-9;
/** Of the clearance: a particle that is nearer to a wall rests against it. */
const AT_WALL = 1e-9;

/**
 * @typedef {{damping: number, friction: number, mass: number, clearance: number | null, forced: boolean}}
 *   Damper ζ, γ_F, β and d/Z, no clearance where there is no particle; and whether a force excites the
 *   structure in place of its base
 */

/**
 * The forces, one value a sample; the one that excites is 0 on a shaken base. Friction that holds the
 * structure is what keeps it moving with its base.
 *
 * @param {import("./history.js").History} history
 * @param {Damper} damper
 * @returns {{spring: number[], damping: number[], friction: number[], force: number[]}}
 */
export function forcesOn(history, { damping, friction, mass, clearance, forced }) {
  const { u, v, v_rate } = history.columns;
  const slowest = HELD * v_rate.reduce((most, rate) => Math.max(most, Math.abs(rate)), 0);
  const cavity = history.inCavity;
  const force = history.cycles.map((cycle) => (forced ? Math.sin(2 * Math.PI * cycle) : 0));
  const held = (/** @type {number} */ i) => {
    const gap = cavity[i];
    const rests = clearance !== null && gap !== null && Math.abs(gap) >= clearance * (1 - AT_WALL);
    // the base's acceleration is −r² z; a particle at rest against a wall is carried along
    const wanted = v[i] - (rests ? 1 + mass : 1) * history.r ** 2 * (u[i] - v[i]) - force[i];
    return Math.max(-friction, Math.min(friction, wanted));
  };
  return {
    spring: v.map((value) => 0 - value),
    damping: v_rate.map((rate) => 0 - 2 * damping * rate),
    friction: v_rate.map((rate, i) => (Math.abs(rate) > slowest ? 0 - friction * Math.sign(rate) : held(i))),
    force,
  };
}

/**
 * @param {import("./history.js").History} history
 * @param {Damper} damper
 * @param {number} factor from k·Z to what is shown
 */
export function forceTraces(history, damper, factor) {
  const forces = forcesOn(history, damper);
  const named = /** @type {[keyof typeof forces, string][]} */ ([
    ["spring", "spring"],
    ["damping", "damping of the structure"],
    ["friction", "friction"],
    ["force", "force F₀ sin ωt"],
  ]);
  return named
    .filter(([name]) => forces[name].some((force) => force !== 0))
    .map(([name, title], i) => ({
      type: "scatter",
      mode: "lines",
      x: history.cycles,
      y: forces[name].map((force) => force * factor),
      name: title,
      line: { color: CURVES()[i], dash: DASHES[i], width: 1.4 },
    }));
}
