/**
 * A sketch of the damper that moves as it was computed: base, spring and dashpot, friction pad, cavity and
 * particle.
 */
/** @import { History } from "./types.js" */

import { el, fill } from "./dom.js";

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 760;
const HEIGHT = 190;
/** Where the base, the mass and the floor are at rest, in the picture's own units. */
const WALL = 70;
const MIDDLE = 420;
const FLOOR = 160;
const RADIUS = 13;
/** How far the mass may move in the picture, and how wide half its cavity may be. */
const TRAVEL = 120;
const HALF_CAVITY = 110;
const SECONDS_PER_CYCLE = 1.6;
const SLOW = 4;
/** Of a cycle: how long an impact is shown, and one step of the button. */
const FLASH = 0.02;
const STEP = 1 / 64;
/** Slip slower than this share of the base's own speed is shown as stick. */
const STUCK = 1e-9;
/** Nearer to a wall than this share of the clearance the particle rides on it. */
const RIDES = 1e-6;

/**
 * @template {keyof SVGElementTagNameMap} Name
 * @param {Name} name
 * @param {Record<string, unknown>} attributes
 * @param {...(Element | string)} children
 * @returns {SVGElementTagNameMap[Name]}
 */
export function svg(name, attributes, ...children) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.append(...children);
  return element;
}

/** A spring from 0 to a length. @param {number} length */
export function coil(length) {
  const turns = 12;
  const points = Array.from(
    { length: turns + 1 },
    (_, i) => `${(16 + ((length - 32) * i) / turns).toFixed(1)},${i % 2 ? -9 : 9}`,
  );
  return `M0,0 H16 L${points.slice(1, -1).join(" ")} L${(length - 16).toFixed(1)},0 H${length.toFixed(1)}`;
}

/** A dashpot from 0 to a length: a piston in a cylinder. @param {number} length */
export function cylinder(length) {
  const middle = length / 2;
  return (
    `M0,0 H${middle - 4} M${middle - 4},-8 V8 M${middle - 20},-12 H${middle + 18} V12 H${middle - 20} ` +
    `M${middle + 18},0 H${length}`
  );
}

/**
 * The sketch with its controls; it stands still until it is played.
 *
 * @param {History} history
 * @param {{clearance: number | null, friction: number}} design clearance over Z, and the friction ratio
 * @param {(u: number) => string} say puts a displacement over Z into words
 */
export function sketch(history, { clearance, friction }, say) {
  const largest = Math.max(1, ...history.columns.u.map(Math.abs));
  const scale = Math.min(TRAVEL / largest, clearance === null ? Infinity : HALF_CAVITY / clearance);
  const half = clearance === null ? 40 : clearance * scale + RADIUS;
  const box = half + 22;

  const base = svg(
    "g",
    {},
    svg("path", { d: `M0,20 V${FLOOR} H${WIDTH - WALL - 20}`, class: "line thick" }),
    svg("path", {
      d: `M0,20 L-14,34 M0,50 L-14,64 M0,80 L-14,94 M0,110 L-14,124 M0,140 L-14,154`,
      class: "line",
    }),
  );
  const spring = svg("path", { class: "line" });
  const dashpot = svg("path", { class: "line" });
  const pad = svg("rect", { x: -26, y: 118, width: 52, height: FLOOR - 120, class: "pad" });
  const left = svg("line", { x1: -half, x2: -half, y1: 58, y2: 92, class: "line thick" });
  const right = svg("line", { x1: half, x2: half, y1: 58, y2: 92, class: "line thick" });
  const mass = svg(
    "g",
    {},
    svg("rect", { x: -box, y: 36, width: 2 * box, height: 82, rx: 4, class: "mass" }),
  );
  if (clearance !== null)
    mass.append(svg("rect", { x: -half, y: 58, width: 2 * half, height: 34, class: "cavity" }), left, right);
  if (friction > 0) mass.append(pad);
  const particle = svg("circle", { cy: 75, r: RADIUS, class: "particle" });
  const picture = svg("svg", {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
    class: "sketch",
    role: "img",
    "aria-label": "Sketch of the damper as it moves",
  });
  picture.append(base, spring, dashpot, mass, ...(clearance === null ? [] : [particle]));

  const words = el("output", {});
  const slider = el("input", {
    type: "range",
    min: 0,
    max: Math.max(1, history.length),
    step: "any",
    value: 0,
    "aria-label": "Moment of the motion, in cycles",
    oninput: () => show(Number(slider.value)),
  });
  const play = el("button", { type: "button", onclick: () => (running ? stop() : start()) }, "Play");
  const slow = el("input", { type: "checkbox" });
  const struck = history.impacts.map((i) => history.cycles[i]);
  let now = 0;
  let running = false;

  /** @param {number} cycle */
  function show(cycle) {
    now = cycle;
    const z = history.base(cycle) * scale;
    const u = history.at("u", cycle) * scale;
    const x = MIDDLE + u - box - WALL - z;
    base.setAttribute("transform", `translate(${WALL + z},0)`);
    mass.setAttribute("transform", `translate(${MIDDLE + u},0)`);
    spring.setAttribute("transform", `translate(${WALL + z},62)`);
    spring.setAttribute("d", coil(x));
    dashpot.setAttribute("transform", `translate(${WALL + z},96)`);
    dashpot.setAttribute("d", cylinder(x));
    slider.value = String(cycle);
    slider.setAttribute("aria-valuetext", `${cycle.toFixed(2)} of ${history.length} cycles`);
    const hit = struck.some((one) => cycle >= one && cycle - one < FLASH);
    const slips = Math.abs(history.at("v_rate", cycle)) > STUCK * history.r;
    let place = "";
    if (clearance !== null) {
      const p = history.at("p", cycle);
      const inside = p - history.at("u", cycle);
      particle.setAttribute("cx", String(MIDDLE + p * scale));
      particle.classList.toggle("hit", hit);
      left.classList.toggle("hit", hit && inside < 0);
      right.classList.toggle("hit", hit && inside > 0);
      const rides = clearance - Math.abs(inside) < RIDES * clearance && !hit;
      place = hit ? ", impact" : rides ? ", the particle rides on a wall" : ", the particle flies";
    }
    pad.classList.toggle("sticks", !slips);
    const contact = friction > 0 ? (slips ? ", slip" : ", stick") : "";
    words.textContent = `Cycle ${cycle.toFixed(2)}: x = ${say(history.at("u", cycle))}${contact}${place}`;
  }

  function start() {
    if (!history.length) return;
    running = true;
    play.textContent = "Pause";
    let last = performance.now();
    const frame = (/** @type {number} */ time) => {
      if (!running || !picture.isConnected) return stop();
      const speed = slow.checked ? SECONDS_PER_CYCLE * SLOW : SECONDS_PER_CYCLE;
      show((now + (time - last) / 1000 / speed) % history.length);
      last = time;
      requestAnimationFrame(frame);
    };
    requestAnimationFrame((time) => {
      last = time;
      frame(time);
    });
  }

  function stop() {
    running = false;
    play.textContent = "Play";
  }

  /** @param {number} by cycles */
  function step(by) {
    stop();
    show((now + by + history.length) % history.length);
  }

  const element = el("div", { class: "sketch-box" });
  fill(
    element,
    picture,
    el(
      "div",
      { class: "row controls" },
      play,
      el(
        "button",
        { type: "button", class: "small", "aria-label": "One step back", onclick: () => step(-STEP) },
        "◀",
      ),
      el(
        "button",
        { type: "button", class: "small", "aria-label": "One step on", onclick: () => step(STEP) },
        "▶",
      ),
      el("label", { class: "check" }, slow, "Slow"),
    ),
    slider,
    el("p", { class: "quiet" }, words),
  );
  show(0);
  return element;
}
