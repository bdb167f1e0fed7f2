/** All designs at once: parallel coordinates that can be brushed, by the pointer on an axis or by sliders. */
/** @import { Ranked, Session } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, el, fill } from "./dom.js";
import { leading, VALUE } from "./headline.js";
import { short } from "./numbers.js";
import { FREQUENCY } from "./selection.js";

const MOST = 2000;
const HEIGHT = 260;
const [TOP, BOTTOM] = [26, 240];
/** Between two axes, in units of the drawing. */
const STEP = 130;
const STEPS = 100;
const PATIENCE_MILLISECONDS = 300;

/**
 * @typedef {{name: string, title: string, low: number, high: number, of: (design: Ranked) => number, text:
 *   (value: number) => string}} Axis
 */

/** @param {Session} session @returns {{element: HTMLElement, look: () => void}} */
export function parallelPanel(session) {
  const { selection, record, kept, shown } = session;
  const place = el("div");
  const said = el("p", { class: "quiet", role: "status" });
  const limits = { speed: kept.number("speed", 0, Infinity, NaN), stuck: kept.number("stuck", 0, 1, NaN) };
  /** @type {Ranked[]} */
  let found = [];
  /** @type {Axis[]} */
  let axes = [];
  /** Ends of each brush, as shares of its axis. @type {Record<string, [number, number]>} */
  let brushes = {};
  let total = 0;
  let asked = 0;

  async function look() {
    const mine = ++asked;
    const filters = {
      ...(Number.isFinite(limits.speed)
        ? { max_impact_speed: limits.speed / shown.factor("impact_speed_max") }
        : {}),
      ...(Number.isFinite(limits.stuck) ? { stick_fraction: `0,${limits.stuck}` } : {}),
    };
    try {
      const ranked = await ask(studyPath(record.id, "optimal-designs"), { top: MOST, ...filters });
      if (mine !== asked) return;
      found = ranked.designs;
      total = ranked.designs_total;
      axes = axesOf(session, found);
      brushes = Object.fromEntries(
        axes.map(({ name }) => [name, brushes[name] ?? readBrush(kept.values[`brush_${name}`])]),
      );
      fill(place, found.length > 0 && [drawing(), bySliders()]);
      update();
    } catch (error) {
      if (mine === asked) fill(place, refusalBox(error));
    }
  }

  const soon = debounced(PATIENCE_MILLISECONDS, look);

  const within = (/** @type {Ranked} */ design) =>
    axes.every((axis) => {
      const share = shareOf(axis, axis.of(design));
      return share >= brushes[axis.name][0] - 1e-9 && share <= brushes[axis.name][1] + 1e-9;
    });

  /** @type {Record<string, SVGElement>} */
  let parts = {};

  function drawing() {
    const width = STEP * (axes.length - 1) + 150;
    parts = { muted: line("muted"), inside: line("inside"), point: line("point"), best: line("best") };
    const heads = axes.flatMap((axis, i) => [
      svg("line", { x1: xOf(i), x2: xOf(i), y1: TOP, y2: BOTTOM, class: "rail" }),
      svg("text", { x: xOf(i), y: 14, "text-anchor": "middle" }, axis.title),
      svg("text", { x: xOf(i) - 4, y: TOP + 4, "text-anchor": "end", class: "tick" }, axis.text(axis.high)),
      svg("text", { x: xOf(i) - 4, y: BOTTOM + 4, "text-anchor": "end", class: "tick" }, axis.text(axis.low)),
      (parts[`brush ${axis.name}`] = svg("rect", { x: xOf(i) - 6, width: 12, class: "brush" })),
      brushing(
        axis,
        svg("rect", { x: xOf(i) - 18, y: TOP - 8, width: 36, height: BOTTOM - TOP + 16, class: "handle" }),
      ),
    ]);
    const label = `Parallel coordinates of ${found.length} designs; the sliders below limit each axis`;
    const picture = svg(
      "svg",
      { viewBox: `0 0 ${width} ${HEIGHT}`, class: "parallel", role: "img", "aria-label": label },
      parts.muted,
      parts.inside,
      parts.point,
      parts.best,
      ...heads,
    );
    picture.style.minWidth = `${120 * axes.length}px`;
    return el(
      "div",
      { class: "scroll", tabindex: 0, role: "region", "aria-label": "Parallel coordinates" },
      picture,
    );
  }

  /**
   * A drag along an axis brushes it, a click on it takes the brush away.
   *
   * @param {Axis} axis
   * @param {SVGElement} handle
   */
  function brushing(axis, handle) {
    let first = 0;
    const share = (/** @type {PointerEvent} */ event) => {
      const box = handle.getBoundingClientRect();
      const y = TOP - 8 + ((event.clientY - box.top) / box.height) * (BOTTOM - TOP + 16);
      return Math.min(1, Math.max(0, (BOTTOM - y) / (BOTTOM - TOP)));
    };
    handle.addEventListener("pointerdown", (event) => {
      handle.setPointerCapture(event.pointerId);
      first = share(event);
    });
    handle.addEventListener("pointermove", (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const now = share(event);
      brushes[axis.name] =
        Math.abs(now - first) < 0.02 ? [0, 1] : [Math.min(first, now), Math.max(first, now)];
      update();
    });
    handle.addEventListener("pointerup", (event) => {
      if (Math.abs(share(event) - first) < 0.02) brushes[axis.name] = [0, 1];
      update();
      keep();
    });
    return handle;
  }

  /** @type {Record<string, [HTMLInputElement, HTMLInputElement, HTMLOutputElement]>} */
  let inputs = {};

  function bySliders() {
    inputs = {};
    const rows = axes.map((axis) => {
      const [from, to] = [0, 1].map((end) => {
        const slider = el("input", {
          type: "range",
          min: 0,
          max: STEPS,
          step: 1,
          "aria-label": `${axis.title}, ${end ? "at most" : "at least"}`,
          oninput: () => {
            const value = Number(slider.value) / STEPS;
            const [low, high] = brushes[axis.name];
            brushes[axis.name] = end ? [Math.min(low, value), value] : [value, Math.max(high, value)];
            update();
          },
          onchange: () => keep(),
        });
        return slider;
      });
      const output = el("output", {});
      inputs[axis.name] = [from, to, output];
      return el(
        "div",
        { class: "brushes" },
        el("span", { "aria-hidden": "true" }, axis.title),
        from,
        to,
        output,
      );
    });
    return el(
      "details",
      {},
      el("summary", {}, "Limit the axes by sliders"),
      el("fieldset", { class: "sliders" }, el("legend", {}, "Show only designs with"), rows),
    );
  }

  function keep() {
    const whole = ([low, high] = [0, 1]) => low <= 0 && high >= 1;
    kept.keep(
      Object.fromEntries(
        axes.map(({ name }) => [
          `brush_${name}`,
          whole(brushes[name]) ? null : brushes[name].map((share) => short(share, 4)).join(","),
        ]),
      ),
    );
  }

  /** Draw what the brushes leave. */
  function update() {
    if (found.length === 0) return void fill(said, "No design is left.");
    const inside = found.filter(within);
    const best = leading({
      designs: inside,
      best_with_impacts: inside.find((design) => design.impact_share > 0),
    }).best;
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
    for (const axis of axes) {
      const [low, high] = brushes[axis.name];
      const rect = parts[`brush ${axis.name}`];
      rect.setAttribute("y", String(BOTTOM - high * (BOTTOM - TOP)));
      rect.setAttribute("height", String((high - low) * (BOTTOM - TOP)));
      rect.setAttribute("visibility", low > 0 || high < 1 ? "visible" : "hidden");
      const [least, most, output] = inputs[axis.name];
      [least.value, most.value] = [String(Math.round(low * STEPS)), String(Math.round(high * STEPS))];
      const text = (/** @type {number} */ share) => axis.text(axis.low + share * (axis.high - axis.low));
      output.textContent = `${text(low)} to ${text(high)}`;
      least.setAttribute("aria-valuetext", text(low));
      most.setAttribute("aria-valuetext", text(high));
    }
    const of =
      total > found.length
        ? ` The study has ${total}: designs without impacts that share one response are drawn as one ` +
          `line, and at most ${MOST} lines are drawn.`
        : "";
    fill(
      said,
      `${inside.length} of ${found.length} designs are within the limits.${of} `,
      best &&
        el(
          "button",
          {
            type: "button",
            class: "small",
            onclick: () =>
              selection.chooseValues(
                Object.fromEntries(
                  selection.varied.filter((name) => name !== FREQUENCY).map((name) => [name, best[name]]),
                ),
              ),
          },
          `Go to the best of them, ${shown.value(VALUE, best.value)}`,
        ),
    );
  }

  /** @param {string} label @param {"speed" | "stuck"} name @param {Record<string, unknown>} more */
  function limit(label, name, more) {
    const input = el("input", {
      type: "number",
      step: "any",
      min: 0,
      placeholder: "any",
      value: Number.isFinite(limits[name]) ? limits[name] : "",
      ...more,
      oninput: () => {
        limits[name] = input.value === "" ? NaN : Number(input.value);
        kept.keep({ [name]: input.value });
        soon();
      },
    });
    return el("label", { class: "field" }, el("span", {}, label), input);
  }

  selection.addEventListener("chosen", () => found.length > 0 && update());
  const has = (/** @type {string} */ name) => session.variables.includes(name);
  const element = el(
    "section",
    { class: "box wide" },
    el("h2", {}, "All designs"),
    el(
      "p",
      { class: "quiet" },
      "Each line is a design. Drag along an axis to keep only the designs that cross it there; click " +
        "the axis to remove the limit.",
    ),
    el(
      "div",
      { class: "row controls" },
      has("impact_speed_max") &&
        limit(`Impact speed at most${shown.has("impact_speed_max") ? " [m/s]" : " [Z ω_n]"}`, "speed", {}),
      has("stick_fraction") && limit("Share of time sticking at most", "stuck", { max: 1 }),
    ),
    said,
    place,
  );
  return { element, look };
}

/**
 * The axes: what varies, and what comes of it.
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
  const plain = (/** @type {string} */ name) =>
    (shown.has(name)
      ? shown.title(name).replace(/^.* (?=\S+ \[)/, "")
      : shown.title(name).replace(/^.* /, "")
    ).replace("_", "");
  return [
    ...named.map((name) =>
      axis(
        name,
        plain(name),
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
      shown.has(VALUE) ? `X${shown.unit(VALUE).replace(/^ (.*)$/, " [$1]")}` : "X/Z",
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
