/** The point as sliders, one for each dimension that varies: what a click on the map does, keys do here. */

import { checkbox, el, fill } from "./dom.js";
import { short } from "./numbers.js";
import { unitFactor } from "./quantities.js";
import { FREQUENCY, RECORD } from "./selection.js";
import { NAMES, symbol } from "./vocabulary.js";

const UNITS = /** @type {Record<string, [string, number]>} */ ({
  clearance_ratio: ["mm", 1000],
  friction_ratio: ["N", 1],
  frequency_ratio: ["Hz", 1],
  mass_ratio: ["kg", 1],
});

/**
 * A value in the study's units, where it has any.
 *
 * @param {string} dimension
 * @param {number} value
 * @param {any} definition of the study
 */
export function inUnit(dimension, value, definition) {
  const factor = definition.physical ? unitFactor(dimension, definition.physical) : null;
  if (factor === null) return "";
  const [unit, scale] = UNITS[dimension];
  return ` (${short(value * factor * scale, 4)} ${unit})`;
}

/**
 * The sliders of a point.
 *
 * @param {import("./selection.js").Selection} selection
 * @param {any} definition of the study
 * @param {boolean} [curves] what is asked for are curves over the frequency, so it is not chosen
 */
export function sliders(selection, definition, curves = false) {
  const place = el("fieldset", { class: "sliders" });
  /** @type {Record<string, {slider: any, output: any}>} */
  const parts = {};
  const shown = selection.varied.filter((dimension) => dimension !== RECORD && (!curves || dimension !== FREQUENCY));
  const rows = shown.map((dimension) => {
    const values = selection.axes[dimension];
    const output = el("output", {});
    const slider = el("input", {
      type: "range",
      min: 0,
      max: values.length - 1,
      step: 1,
      "aria-label": `${NAMES[dimension]} of the point`,
      oninput: () => selection.choose({ [dimension]: Number(slider.value) }),
    });
    parts[dimension] = { slider, output };
    return el("div", { class: "slider" }, el("span", { "aria-hidden": "true" }, NAMES[dimension], " ", symbol(dimension)), slider, output);
  });
  const band = shown.includes(FREQUENCY);
  const worst = checkbox("Judge by the worst over all frequencies", selection.worst, (on) => selection.leaveFrequency(on));
  fill(place, el("legend", {}, "The design point"), rows, band && worst);

  function update() {
    for (const [dimension, { slider, output }] of Object.entries(parts)) {
      const value = selection.value(dimension);
      const text = `${short(value, 6)}${inUnit(dimension, value, definition)}`;
      slider.value = String(selection.place[dimension]);
      slider.setAttribute("aria-valuetext", text);
      slider.disabled = dimension === FREQUENCY && selection.worst;
      output.textContent = slider.disabled ? "the worst" : text;
    }
  }
  selection.addEventListener("chosen", update);
  update();
  return place;
}
