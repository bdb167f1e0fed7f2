/** Shows all designs as parallel coordinates. The axes are limited with the pointer or with sliders. */
/** @import { Ranked, Session } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, details, el, fill, quiet, smallButton } from "./dom.js";
import { leading, VALUE } from "./headline.js";
import { short } from "./numbers.js";
import { FREQUENCY } from "./selection.js";

const MOST = 2000;
const HEIGHT = 260;
const [TOP, BOTTOM] = [26, 240];
/** Distance between two axes, in units of the drawing. */
const STEP = 130;
const STEPS = 100;
const PATIENCE_MILLISECONDS = 300;

/**
 * @typedef {{name: string, title: string, low: number, high: number, of: (design: Ranked) => number, text:
 *   (value: number) => string}} Axis
 */

export class ParallelPanel {
  place = el("div");
  said = el("p", { class: "quiet", role: "status" });
  /** @type {Ranked[]} */
  found = [];
  /** Whether the friction of the first design clamps the structure. @type {boolean | undefined} */
  clamped;
  /** @type {Axis[]} */
  axes = [];
  /** Ends of the brush (selected range) of each axis, 0 to 1. @type {Record<string, [number, number]>} */
  brushes = {};
  /** @type {Record<string, [HTMLInputElement, HTMLInputElement, HTMLOutputElement]>} */
  inputs = {};
  /** @type {Record<string, SVGElement>} */
  parts = {};
  total = 0;
  asked = 0;

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    const { selection, kept, shown, variables } = session;
    this.limits = { speed: kept.number("speed", 0, Infinity, NaN), stuck: kept.number("stuck", 0, 1, NaN) };
    this.soon = debounced(PATIENCE_MILLISECONDS, () => this.look());
    selection.addEventListener("chosen", () => this.found.length > 0 && this.update());
    const unit = shown.has("impact_speed_max") ? " [m/s]" : " [Z ω_n]";
    this.element = el(
      "section",
      { class: "box wide" },
      el("h2", {}, "All designs"),
      quiet(
        "Each line is a design. Drag along an axis to keep only the designs that cross it there; click " +
          "the axis to remove the limit.",
      ),
      el(
        "div",
        { class: "row controls" },
        variables.includes("impact_speed_max") && this.limit(`Impact speed at most${unit}`, "speed", {}),
        variables.includes("stick_fraction") &&
          this.limit("Share of time sticking at most", "stuck", { max: 1 }),
      ),
      this.said,
      this.place,
    );
  }

  /** @param {string} label @param {"speed" | "stuck"} name @param {Record<string, unknown>} more */
  limit(label, name, more) {
    const now = this.limits[name];
    const oninput = () => {
      this.limits[name] = input.value === "" ? NaN : Number(input.value);
      this.session.kept.keep({ [name]: input.value });
      this.soon();
    };
    const value = Number.isFinite(now) ? now : "";
    const looks = { type: "number", step: "any", min: 0, placeholder: "any", value, ...more, oninput };
    const input = el("input", looks);
    return el("label", { class: "field" }, el("span", {}, label), input);
  }

  /** The limits on impact speed and sticking, as parameters of the request. */
  filters() {
    const { speed, stuck } = this.limits;
    return {
      max_impact_speed: Number.isFinite(speed) ? speed / this.session.shown.factor("impact_speed_max") : null,
      stick_fraction: Number.isFinite(stuck) ? `0,${stuck}` : null,
    };
  }

  async look() {
    const mine = ++this.asked;
    const { record, kept } = this.session;
    try {
      const path = studyPath(record.id, "optimal-designs");
      const ranked = await ask(path, { top: MOST, ...this.filters() });
      if (mine !== this.asked) return;
      this.found = ranked.designs;
      this.clamped = ranked.clamped;
      this.total = ranked.designs_total;
      this.axes = axesOf(this.session, this.found);
      this.brushes = Object.fromEntries(
        this.axes.map(({ name }) => [name, this.brushes[name] ?? readBrush(kept.values[`brush_${name}`])]),
      );
      fill(this.place, this.found.length > 0 && [this.drawing(), this.bySliders()]);
      this.update();
    } catch (error) {
      if (mine === this.asked) fill(this.place, refusalBox(error));
    }
  }

  drawing() {
    const { axes } = this;
    const width = STEP * (axes.length - 1) + 150;
    this.parts = { muted: line("muted"), inside: line("inside"), point: line("point"), best: line("best") };
    const lines = Object.values(this.parts);
    const heads = axes.flatMap((axis, i) => this.head(axis, i));
    const label = `Parallel coordinates of ${this.found.length} designs; the sliders below limit each axis`;
    const looks = { viewBox: `0 0 ${width} ${HEIGHT}`, class: "parallel", role: "img", "aria-label": label };
    const picture = svg("svg", looks, ...lines, ...heads);
    picture.style.minWidth = `${120 * axes.length}px`;
    return el(
      "div",
      { class: "scroll", tabindex: 0, role: "region", "aria-label": "Parallel coordinates" },
      picture,
    );
  }

  /**
   * An axis with its ends, its brush, and the area that takes the pointer.
   *
   * @param {Axis} axis
   * @param {number} i
   */
  head(axis, i) {
    const x = xOf(i);
    const brush = svg("rect", { x: x - 6, width: 12, class: "brush" });
    this.parts[`brush ${axis.name}`] = brush;
    const place = { x: x - 18, y: TOP - 8, width: 36, height: BOTTOM - TOP + 16 };
    return [
      svg("line", { x1: x, x2: x, y1: TOP, y2: BOTTOM, class: "rail" }),
      svg("text", { x, y: 14, "text-anchor": "middle" }, axis.title),
      svg("text", { x: x - 4, y: TOP + 4, "text-anchor": "end", class: "tick" }, axis.text(axis.high)),
      svg("text", { x: x - 4, y: BOTTOM + 4, "text-anchor": "end", class: "tick" }, axis.text(axis.low)),
      brush,
      this.brushing(axis, svg("rect", { ...place, class: "handle" })),
    ];
  }

  /**
   * Let the pointer select a range. A drag along an axis makes a brush, and a click on the axis removes the
   * brush.
   *
   * @param {Axis} axis
   * @param {SVGElement} handle
   */
  brushing({ name }, handle) {
    let first = 0;
    const share = (/** @type {PointerEvent} */ event) => {
      const box = handle.getBoundingClientRect();
      const y = TOP - 8 + ((event.clientY - box.top) / box.height) * (BOTTOM - TOP + 16);
      return Math.min(1, Math.max(0, (BOTTOM - y) / (BOTTOM - TOP)));
    };
    const brush = (/** @type {number} */ now) => {
      const clicked = Math.abs(now - first) < 0.02;
      this.brushes[name] = clicked ? [0, 1] : [Math.min(first, now), Math.max(first, now)];
      this.update();
    };
    handle.addEventListener("pointerdown", (event) => {
      handle.setPointerCapture(event.pointerId);
      first = share(event);
    });
    handle.addEventListener("pointermove", (event) => {
      if (handle.hasPointerCapture(event.pointerId)) brush(share(event));
    });
    handle.addEventListener("pointerup", (event) => {
      brush(share(event));
      this.keep();
    });
    return handle;
  }

  bySliders() {
    const rows = this.axes.map((axis) => {
      const [from, to] = [this.slider(axis, 0), this.slider(axis, 1)];
      const output = el("output", {});
      this.inputs[axis.name] = [from, to, output];
      const title = el("span", { "aria-hidden": "true" }, axis.title);
      return el("div", { class: "brushes" }, title, from, to, output);
    });
    return details(
      "Limit the axes by sliders",
      el("fieldset", { class: "sliders" }, el("legend", {}, "Show only designs with"), rows),
    );
  }

  /** A slider for one end of a brush. @param {Axis} axis @param {0 | 1} end */
  slider({ name, title }, end) {
    const oninput = () => {
      const value = Number(slider.value) / STEPS;
      const [low, high] = this.brushes[name];
      this.brushes[name] = end ? [Math.min(low, value), value] : [value, Math.max(high, value)];
      this.update();
    };
    const label = `${title}, ${end ? "at most" : "at least"}`;
    const looks = { min: 0, max: STEPS, step: 1, "aria-label": label, oninput, onchange: () => this.keep() };
    const slider = el("input", { type: "range", ...looks });
    return slider;
  }

  keep() {
    const kept = this.axes.map(({ name }) => {
      const [low, high] = this.brushes[name];
      const whole = low <= 0 && high >= 1;
      return [`brush_${name}`, whole ? null : `${short(low, 4)},${short(high, 4)}`];
    });
    this.session.kept.keep(Object.fromEntries(kept));
  }

  /** Whether a design is within the brushes. @param {Ranked} design */
  within(design) {
    return this.axes.every((axis) => {
      const share = shareOf(axis, axis.of(design));
      const [low, high] = this.brushes[axis.name];
      return share >= low - 1e-9 && share <= high + 1e-9;
    });
  }

  /** Draw the designs within the brushes. */
  update() {
    const { found, axes, parts } = this;
    if (found.length === 0) return void fill(this.said, "No design is left.");
    const { selection } = this.session;
    const inside = found.filter((design) => this.within(design));
    const { best } = leading({
      designs: inside,
      best_with_impacts: inside.find((design) => design.impact_share > 0),
      clamped: this.clamped && inside[0] === found[0],
    });
    const here = found.find((design) =>
      selection.varied.every((name) => name === FREQUENCY || design[name] === selection.value(name)),
    );
    const path = (/** @type {Ranked[]} */ designs) =>
      designs
        .map((design) => "M" + axes.map((axis, i) => `${xOf(i)},${yOf(axis, axis.of(design))}`).join("L"))
        .join("");
    parts.muted.setAttribute("d", path(found));
    parts.inside.setAttribute("d", path(inside));
    parts.best.setAttribute("d", best ? path([best]) : "");
    parts.point.setAttribute("d", here ? path([here]) : "");
    for (const axis of axes) this.drawBrush(axis);
    this.say(inside.length, best);
  }

  /** @param {Axis} axis */
  drawBrush(axis) {
    const [low, high] = this.brushes[axis.name];
    const rect = this.parts[`brush ${axis.name}`];
    rect.setAttribute("y", String(BOTTOM - high * (BOTTOM - TOP)));
    rect.setAttribute("height", String((high - low) * (BOTTOM - TOP)));
    rect.setAttribute("visibility", low > 0 || high < 1 ? "visible" : "hidden");
    const [from, to, output] = this.inputs[axis.name];
    const [least, most] = [low, high].map((share) => axis.text(axis.low + share * (axis.high - axis.low)));
    from.value = String(Math.round(low * STEPS));
    to.value = String(Math.round(high * STEPS));
    from.setAttribute("aria-valuetext", least);
    to.setAttribute("aria-valuetext", most);
    output.textContent = `${least} to ${most}`;
  }

  /** @param {number} inside number of designs within the brushes @param {Ranked | null} best best of these */
  say(inside, best) {
    const { selection, shown } = this.session;
    const { found, total } = this;
    const of =
      total > found.length
        ? ` The study has ${total}: designs without impacts that share one response are drawn as one ` +
          `line, and at most ${MOST} lines are drawn.`
        : "";
    const words = best && `Go to the best of them, ${shown.value(VALUE, best.value)}`;
    fill(
      this.said,
      `${inside} of ${found.length} designs are within the limits.${of} `,
      best && smallButton(words, () => selection.chooseDesign(best)),
    );
  }
}

/**
 * The axes: the varied quantities and the results.
 *
 * @param {Session} session
 * @param {Ranked[]} designs
 * @returns {Axis[]}
 */
function axesOf({ selection, shown }, designs) {
  const span = (/** @type {number[]} */ values) =>
    values.reduce(
      ([low, high], value) => [Math.min(low, value), Math.max(high, value)],
      [Infinity, -Infinity],
    );
  const axis = (
    /** @type {string} */ name,
    /** @type {string} */ title,
    /** @type {(design: Ranked) => number} */ of,
    /** @type {(value: number) => string} */ text,
  ) => {
    const [low, high] = span(designs.map(of));
    return { name, title, low, high: high > low ? high : low + 1, of, text };
  };
  const named = selection.varied.filter((name) => name !== FREQUENCY);
  return [
    ...named.map((name) =>
      axis(
        name,
        shown.short(name),
        (design) => design[name],
        (value) => short(value * shown.factor(name), 3),
      ),
    ),
    axis(
      "impact_share",
      "impacts",
      (design) => design.impact_share ?? 0,
      (value) => `${short(100 * value, 3)} %`,
    ),
    axis(
      "value",
      shown.has(VALUE) ? `X${shown.inBrackets(VALUE)}` : "X/Z",
      (design) => design.value,
      (value) => short(value * shown.factor(VALUE), 3),
    ),
  ];
}

/** @param {string | undefined} text @returns {[number, number]} */
function readBrush(text) {
  const [low, high] = (text ?? "").split(",").map(Number);
  return text && low >= 0 && high <= 1 && low <= high ? [low, high] : [0, 1];
}

/** @param {Axis} axis @param {number} value */
function shareOf(axis, value) {
  return (value - axis.low) / (axis.high - axis.low);
}

/** @param {number} i */
function xOf(i) {
  return 70 + STEP * i;
}

/** @param {Axis} axis @param {number} value */
function yOf(axis, value) {
  return (BOTTOM - shareOf(axis, value) * (BOTTOM - TOP)).toFixed(1);
}

/** @param {string} kind */
function line(kind) {
  return svg("path", { class: kind, fill: "none" });
}

/**
 * @param {string} tag
 * @param {Record<string, unknown>} attributes
 * @param {...(Node | string)} children
 * @returns {SVGElement}
 */
function svg(tag, attributes, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}
