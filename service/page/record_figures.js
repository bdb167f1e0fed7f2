/** What a ground-motion record looks like: its acceleration over time, and its response spectrum. */

import { ask, refusalBox } from "./api.js";
import { el, fill } from "./dom.js";
import { CURVES, Figure } from "./figure.js";
import { short } from "./numbers.js";

/**
 * Figures of the record that is chosen, drawn once they are opened.
 *
 * @returns {{element: HTMLElement, show: (id: string) => void}}
 */
export function recordFigures() {
  const time = new Figure({ label: "Acceleration of the base over time", name: "record", height: 220 });
  const spectrum = new Figure({
    label: "Response spectrum of the record",
    name: "record-spectrum",
    height: 260,
  });
  const words = el("p", { class: "quiet" });
  const place = el("div", {});
  const element = el(
    "details",
    { class: "more", ontoggle: () => draw() },
    el("summary", {}, "What the record looks like"),
    place,
  );
  let wanted = "";
  let drawn = "";

  async function draw() {
    if (!element.open || !wanted || wanted === drawn) return;
    const id = (drawn = wanted);
    try {
      const record = await ask(`records/${encodeURIComponent(id)}`);
      if (id !== wanted) return;
      fill(
        words,
        `${record.name}: ${short(record.duration_s, 4)} s in steps of ${short(record.step_s, 3)} s, at ` +
          `most ${short(record.peak_acceleration_g, 3)} g. The spectrum is that of structures with a ` +
          `damping ratio of ${record.damping_ratio} and no damper.`,
      );
      fill(place, words, time.element, spectrum.element);
      const line = { type: "scatter", mode: "lines", line: { color: CURVES()[0], width: 1.2 } };
      const perG = record.peak_acceleration_g / record.peak_acceleration_m_s2;
      const gs = (/** @type {number[]} */ values) => values.map((value) => value * perG);
      await time.draw(
        () => [{ ...line, x: record.time_s, y: gs(record.acceleration_m_s2), name: "acceleration" }],
        () => ({
          xaxis: { title: { text: "time [s]" } },
          yaxis: { title: { text: "acceleration [g]" } },
          showlegend: false,
        }),
      );
      await spectrum.draw(
        () => [{ ...line, x: record.period_s, y: gs(record.pseudo_acceleration_m_s2), name: "spectrum" }],
        () => ({
          xaxis: { title: { text: "natural period [s]" }, type: "log", dtick: "D2" },
          yaxis: { title: { text: "pseudo-acceleration [g]" }, rangemode: "tozero" },
          showlegend: false,
        }),
      );
    } catch (error) {
      if (id === wanted) fill(place, refusalBox(error));
      drawn = "";
    }
  }

  return {
    element,
    show: (id) => {
      wanted = id;
      void draw();
    },
  };
}
