/** An animated sketch of the structure, the particle and the friction pad in a computed motion. */
/** @import { History } from "./types.js" */

import { button, el, quiet, smallButton } from "./dom.js";

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 760;
const HEIGHT = 190;
/** Rest positions of the base, the mass and the floor, in units of the picture. */
const WALL = 70;
const MIDDLE = 420;
const FLOOR = 160;
const RADIUS = 13;
/** Largest motion of the mass in the picture, and largest half width of its cavity. */
const TRAVEL = 120;
const HALF_CAVITY = 110;
const SECONDS_PER_CYCLE = 1.6;
const SLOW = 4;
/** The time for which an impact is shown, and the step of a button, as shares of a cycle. */
const FLASH = 0.02;
const STEP = 1 / 64;
/** Ratio of the slip speed to the speed of the base below which the sketch shows sticking. */
const STUCK = 1e-9;
/** Distance of the particle from a wall, divided by the clearance, below which the sketch shows contact. */
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
 * The sketch with its controls. The animation begins when the user presses the button.
 *
 * @param {History} history
 * @param {{clearance: number | null, friction: number}} design clearance over Z, and the friction ratio
 * @param {(u: number) => string} say formats a displacement over Z
 */
export function sketch(history, design, say) {
  return new Sketch(history, design, say).element;
}

class Sketch {
  now = 0;
  running = false;
  spring = svg("path", { class: "line" });
  dashpot = svg("path", { class: "line" });
  pad = svg("rect", { x: -26, y: 118, width: 52, height: FLOOR - 120, class: "pad" });
  particle = svg("circle", { cy: 75, r: RADIUS, class: "particle" });
  base = svg(
    "g",
    {},
    svg("path", { d: `M0,20 V${FLOOR} H${WIDTH - WALL - 20}`, class: "line thick" }),
    svg("path", {
      d: `M0,20 L-14,34 M0,50 L-14,64 M0,80 L-14,94 M0,110 L-14,124 M0,140 L-14,154`,
      class: "line",
    }),
  );
  words = el("output", {});
  slow = el("input", { type: "checkbox" });
  play = button("Play", () => (this.running ? this.stop() : this.start()));

  /**
   * @param {History} history
   * @param {{clearance: number | null, friction: number}} design
   * @param {(u: number) => string} say
   */
  constructor(history, { clearance, friction }, say) {
    this.history = history;
    this.clearance = clearance;
    this.friction = friction;
    this.say = say;
    const largest = Math.max(1, ...history.columns.u.map(Math.abs));
    this.scale = Math.min(TRAVEL / largest, clearance === null ? Infinity : HALF_CAVITY / clearance);
    this.half = clearance === null ? 40 : clearance * this.scale + RADIUS;
    this.box = this.half + 22;
    this.struck = history.impacts.map((i) => history.cycles[i]);
    const wall = (/** @type {number} */ x) =>
      svg("line", { x1: x, x2: x, y1: 58, y2: 92, class: "line thick" });
    this.walls = [wall(-this.half), wall(this.half)];
    this.mass = this.drawMass();
    const looks = { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "sketch", role: "img" };
    const parts = [this.base, this.spring, this.dashpot, this.mass];
    const label = { "aria-label": "Sketch of the damper as it moves" };
    this.picture = svg(
      "svg",
      { ...looks, ...label },
      ...parts,
      ...(clearance === null ? [] : [this.particle]),
    );
    this.slider = el("input", {
      type: "range",
      min: 0,
      max: Math.max(1, history.length),
      step: "any",
      value: 0,
      "aria-label": "Moment of the motion, in cycles",
      oninput: () => this.show(Number(this.slider.value)),
    });
    this.element = this.drawElement();
    this.show(0);
  }

  drawMass() {
    const { half, box, clearance, friction, walls, pad } = this;
    const cavity = svg("rect", { x: -half, y: 58, width: 2 * half, height: 34, class: "cavity" });
    return svg(
      "g",
      {},
      svg("rect", { x: -box, y: 36, width: 2 * box, height: 82, rx: 4, class: "mass" }),
      ...(clearance === null ? [] : [cavity, ...walls]),
      ...(friction > 0 ? [pad] : []),
    );
  }

  drawElement() {
    return el(
      "div",
      { class: "sketch-box" },
      this.picture,
      el(
        "div",
        { class: "row controls" },
        this.play,
        smallButton("◀", () => this.step(-STEP), "One step back"),
        smallButton("▶", () => this.step(STEP), "One step on"),
        el("label", { class: "check" }, this.slow, "Slow"),
      ),
      this.slider,
      quiet(this.words),
    );
  }

  /** @param {number} cycle */
  show(cycle) {
    this.now = cycle;
    const { history, scale, slider } = this;
    const z = history.base(cycle) * scale;
    const u = history.at("u", cycle) * scale;
    const length = MIDDLE + u - this.box - WALL - z;
    this.base.setAttribute("transform", `translate(${WALL + z},0)`);
    this.mass.setAttribute("transform", `translate(${MIDDLE + u},0)`);
    this.spring.setAttribute("transform", `translate(${WALL + z},62)`);
    this.spring.setAttribute("d", coil(length));
    this.dashpot.setAttribute("transform", `translate(${WALL + z},96)`);
    this.dashpot.setAttribute("d", cylinder(length));
    slider.value = String(cycle);
    slider.setAttribute("aria-valuetext", `${cycle.toFixed(2)} of ${history.length} cycles`);
    const slips = Math.abs(history.at("v_rate", cycle)) > STUCK * history.r;
    this.pad.classList.toggle("sticks", !slips);
    const contact = this.friction > 0 ? (slips ? ", slip" : ", stick") : "";
    const place = this.clearance === null ? "" : this.showParticle(cycle, this.clearance);
    const x = this.say(history.at("u", cycle));
    this.words.textContent = `Cycle ${cycle.toFixed(2)}: x = ${x}${contact}${place}`;
  }

  /** Show the particle, and say whether it touches a wall. @param {number} cycle @param {number} clearance */
  showParticle(cycle, clearance) {
    const { history, particle } = this;
    const [left, right] = this.walls;
    const p = history.at("p", cycle);
    const inside = p - history.at("u", cycle);
    const hit = this.struck.some((one) => cycle >= one && cycle - one < FLASH);
    particle.setAttribute("cx", String(MIDDLE + p * this.scale));
    particle.classList.toggle("hit", hit);
    left.classList.toggle("hit", hit && inside < 0);
    right.classList.toggle("hit", hit && inside > 0);
    if (hit) return ", impact";
    const rides = clearance - Math.abs(inside) < RIDES * clearance;
    return rides ? ", the particle stays on a wall" : ", the particle flies";
  }

  start() {
    const { history } = this;
    if (!history.length) return;
    this.running = true;
    this.play.textContent = "Pause";
    let last = performance.now();
    const frame = (/** @type {number} */ time) => {
      if (!this.running || !this.picture.isConnected) return this.stop();
      const speed = this.slow.checked ? SECONDS_PER_CYCLE * SLOW : SECONDS_PER_CYCLE;
      this.show((this.now + (time - last) / 1000 / speed) % history.length);
      last = time;
      requestAnimationFrame(frame);
    };
    requestAnimationFrame((time) => {
      last = time;
      frame(time);
    });
  }

  stop() {
    this.running = false;
    this.play.textContent = "Play";
  }

  /** @param {number} by cycles */
  step(by) {
    this.stop();
    this.show((this.now + by + this.history.length) % this.history.length);
  }
}
