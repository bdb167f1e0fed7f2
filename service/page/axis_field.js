/**
 * The form field of one quantity of a study, which is a single value, a range or a list.
 *
 * @typedef {Exclude<Spec, number | number[]>} Range
 * @typedef {Spec | null | undefined} Given as typed
 * @typedef {{field: string, label: string, unit?: string, scale?: number, low: number, high: number, step:
 * number, usual: number, help?: string}} Quantity `field` is the path of the quantity in the JSON of a study.
 * `scale` is the factor from the stored to the shown value (1000 for metres in mm). `low`, `high` and `step`
 * describe the slider, and are not the limits of the quantity
 */
/** @import { Spec } from "./types.js" */

import { el, fill } from "./dom.js";
import { listBox } from "./lists.js";

const MODES = /** @type {[string, string][]} */ ([
  ["one", "one value"],
  ["range", "range"],
  ["list", "list"],
]);

/** @param {unknown} spec */
export function modeOf(spec) {
  if (Array.isArray(spec)) return "list";
  return isRange(spec) ? "range" : "one";
}

/**
 * A spec with every number multiplied by a factor, and rounded to remove the rounding error of the product.
 *
 * @template {Given} T
 * @param {T} spec
 * @param {number} factor
 * @param {number} [digits]
 * @returns {T}
 */
export function scaled(spec, factor, digits = 14) {
  const value = (/** @type {unknown} */ one) =>
    typeof one !== "number" || factor === 1 ? one : Number((one * factor).toPrecision(digits));
  if (Array.isArray(spec)) return /** @type {T} */ (spec.map(value));
  if (!isRange(spec)) return /** @type {T} */ (value(spec));
  return /** @type {T} */ ({
    .../** @type {Range} */ (spec),
    start: value(spec.start),
    stop: value(spec.stop),
  });
}

/** @param {unknown} spec @returns {spec is Range} */
function isRange(spec) {
  return spec !== null && typeof spec === "object" && !Array.isArray(spec);
}

/**
 * The fields of one quantity.
 *
 * @param {Quantity} quantity
 * @param {Given} spec the present value in the study
 * @param {(spec: Given) => void} onChange
 * @returns {HTMLElement}
 */
export function axisField(quantity, spec, onChange) {
  const scale = quantity.scale ?? 1;
  let shown = scaled(spec, scale);
  const inputs = el("div", { class: "inputs" });
  const put = (/** @type {Given} */ value) => {
    shown = value;
    onChange(scaled(value, 1 / scale));
  };
  const mode = el(
    "select",
    {
      "aria-label": `${quantity.label}: how it is given`,
      onchange: () => {
        put(converted(shown, mode.value, quantity));
        draw();
      },
    },
    MODES.map(([key, text]) => el("option", { value: key, selected: key === modeOf(spec) }, text)),
  );

  function draw() {
    if (mode.value === "one") fill(inputs, number(quantity, quantity.label, shown, put, true));
    if (mode.value === "range") fill(inputs, rangeInputs(quantity, shown, put));
    if (mode.value === "list") fill(inputs, listInput(quantity, shown, put));
  }
  draw();
  return el(
    "fieldset",
    {
      class: "axis",
      "data-field": quantity.field,
      "data-label": quantity.label,
      ...(scale === 1 ? {} : { "data-unit": quantity.unit, "data-scale": scale }),
    },
    el("legend", {}, quantity.label, quantity.unit ? ` [${quantity.unit}]` : ""),
    mode,
    inputs,
    quantity.help && el("p", { class: "quiet hint" }, quantity.help),
    el("div", { class: "faults" }),
  );
}

/**
 * The new spec of a quantity when the user changes between value, range and list.
 *
 * @param {Given} spec
 * @param {string} mode
 * @param {Quantity} quantity
 */
function converted(spec, mode, quantity) {
  const values = isRange(spec) ? [spec.start, spec.stop] : [spec].flat();
  const known = (/** @type {unknown} */ value, /** @type {number} */ otherwise) =>
    typeof value === "number" && Number.isFinite(value) ? value : otherwise;
  const first = known(values[0], quantity.usual);
  const last = known(values.at(-1), first);
  if (mode === "one") return first;
  if (mode === "list") return first === last ? [first] : [first, last];
  return first === last
    ? { start: quantity.low, stop: quantity.high, num: 11 }
    : { start: Math.min(first, last), stop: Math.max(first, last), num: 11 };
}

/**
 * A number box with a slider. The slider covers the usual range; the box takes any number.
 *
 * @param {Quantity} quantity
 * @param {string} label
 * @param {unknown} value
 * @param {(value: number | null) => void} onChange
 * @param {boolean} [bare] whether only screen readers get the label
 */
function number(quantity, label, value, onChange, bare = false) {
  const box = el("input", { type: "number", step: "any", value: value ?? "", "aria-label": label });
  // a given value outside the usual range extends the slider
  const reach = [quantity.low, quantity.high, ...(typeof value === "number" ? [value] : [])];
  const slider = el("input", {
    type: "range",
    min: Math.min(...reach),
    max: Math.max(...reach),
    step: Math.max(...reach) > quantity.high || Math.min(...reach) < quantity.low ? "any" : quantity.step,
    "aria-label": `${label}, slider`,
    value: value ?? quantity.usual,
  });
  slider.addEventListener("input", () => {
    box.value = String(Number(slider.value));
    onChange(Number(slider.value));
  });
  box.addEventListener("input", () => {
    if (box.value !== "") {
      slider.min = String(Math.min(Number(slider.min), Number(box.value)));
      slider.max = String(Math.max(Number(slider.max), Number(box.value)));
      slider.value = box.value;
    }
    onChange(box.value === "" ? null : Number(box.value));
  });
  return el(
    "div",
    { class: "number" },
    !bare && el("span", { "aria-hidden": "true" }, label.split(": ").at(-1)),
    slider,
    box,
  );
}

/** @param {Quantity} quantity @param {Given} spec @param {(spec: Range) => void} onChange */
function rangeInputs(quantity, spec, onChange) {
  const now = { .../** @type {Range} */ (spec) };
  const put = (/** @type {object} */ change) => onChange({ ...Object.assign(now, change) });
  const num = el("input", {
    type: "number",
    min: 1,
    step: 1,
    value: now.num,
    oninput: () => put({ num: num.value === "" ? null : Number(num.value) }),
  });
  const spacing = el(
    "select",
    { value: now.spacing ?? "linear", onchange: () => put({ spacing: spacing.value }) },
    el("option", { value: "linear" }, "even"),
    el("option", { value: "log" }, "logarithmic"),
  );
  return [
    number(quantity, `${quantity.label}: from`, now.start, (start) => put({ start })),
    number(quantity, `${quantity.label}: to`, now.stop, (stop) => put({ stop })),
    el(
      "div",
      { class: "row" },
      el("label", { class: "inline" }, "values", num),
      el("label", { class: "inline" }, "spacing", spacing),
    ),
  ];
}

/** @param {Quantity} quantity @param {Given} spec @param {(spec: number[]) => void} onChange */
function listInput(quantity, spec, onChange) {
  const looks = { class: "wide", "aria-label": `${quantity.label}: values, separated by commas` };
  // a text that is not a number is sent unchanged, so that the service reports the fault
  const read = (/** @type {string} */ part) =>
    Number.isFinite(Number(part)) ? Number(part) : /** @type {never} */ (part);
  return listBox([spec].flat().join(", "), (parts) => onChange(parts.map(read)), looks);
}
