/** Sliders that move the point by pointer or keyboard, one for each varied dimension. */
/** @import { Selection, Shown } from "./types.js" */

import { checkbox, el, fill } from "./dom.js";
import { AMPLITUDE, FREQUENCY, RECORD } from "./selection.js";
import { NAMES, symbol } from "./vocabulary.js";

/**
 * The sliders of a point.
 *
 * @param {Selection} selection
 * @param {Shown} shown
 * @param {boolean} [curves] whether curves over the frequency are shown, so that no slider sets the frequency
 */
export function sliders(selection, shown, curves = false) {
  const place = el("fieldset", { class: "sliders" });
  /** @type {Record<string, {slider: HTMLInputElement, output: HTMLOutputElement}>} */
  const parts = {};
  const dimensions = selection.varied.filter(
    (dimension) => dimension !== RECORD && dimension !== AMPLITUDE && (!curves || dimension !== FREQUENCY),
  );
  const rows = dimensions.map((dimension) => {
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
    return el(
      "div",
      { class: "slider" },
      el(
        "span",
        { "aria-hidden": "true" },
        shown.has(dimension)
          ? shown.title(dimension)
          : [NAMES[dimension], " ", symbol(dimension), shown.inBrackets(dimension)],
      ),
      slider,
      output,
    );
  });
  const band = dimensions.includes(FREQUENCY);
  const worst = checkbox("Judge by the worst over all frequencies", selection.worst, (on) =>
    selection.leaveFrequency(on),
  );
  fill(place, el("legend", {}, "The design point"), rows, band && worst);

  function update() {
    for (const [dimension, { slider, output }] of Object.entries(parts)) {
      const value = selection.value(dimension);
      const text = shown.value(dimension, value, 6);
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
