/** Form fields that choose or upload ground-motion records, and figures of a record. */
/** @import { GroundRecord } from "./types.js" */

import { ask, faultText, Refusal, refusalBox } from "./api.js";
import { details, el, fill, quiet, say } from "./dom.js";
import { CURVES, Figure } from "./figure.js";
import { short } from "./numbers.js";
import { WORDS } from "./words.js";

/**
 * Fields to choose a record of the service, or to upload a file.
 *
 * @param {string} chosen id of the chosen record
 * @param {(id: string) => void} onChange
 */
export function recordPicker(chosen, onChange) {
  const looks = recordFigures();
  const chose = (/** @type {string} */ id) => {
    looks.show(id);
    onChange(id);
  };
  const select = el("select", { onchange: () => chose(select.value) });
  const trouble = el("div");

  /** @param {string} id */
  async function list(id) {
    const { records } = await ask("records");
    const known = records.some((one) => one.id === id);
    const start = records.find((one) => one.id.startsWith(id))?.id;
    const value = known ? id : (start ?? records[0]?.id);
    fill(
      select,
      records.map((one) =>
        el(
          "option",
          { value: one.id, selected: one.id === value },
          `${one.name} (${short(one.peak_acceleration_g, 2)} g, ${short(one.duration_s, 3)} s)`,
        ),
      ),
    );
    return value;
  }

  list(chosen).then(
    (id) => {
      if (id === undefined) return;
      looks.show(id);
      if (id !== chosen) onChange(id);
    },
    (error) => fill(trouble, refusalBox(error)),
  );
  return el(
    "div",
    { class: "records", "data-field": "record" },
    el("label", { class: "field" }, el("span", {}, "Record"), select),
    uploadField(async (kept) => {
      await list(kept.id);
      chose(kept.id);
    }),
    looks.element,
    trouble,
  );
}

/**
 * Upload a record.
 *
 * @param {Record<string, string>} given
 * @param {RequestInit} options
 * @returns {Promise<GroundRecord>} as listed by the service
 */
async function put(given, options) {
  return /** @type {GroundRecord} */ (/** @type {unknown} */ (await ask("records", given, options)));
}

/**
 * A field that uploads a file as a record.
 *
 * @param {(kept: GroundRecord) => void | Promise<void>} onKept the record as listed by the service
 */
export function uploadField(onKept) {
  const trouble = el("div", { class: "upload faults", role: "alert" });
  const file = el("input", {
    type: "file",
    accept: ".at2,.AT2,.csv,.txt,text/plain,text/csv",
    onchange: () => upload(),
  });
  const names = WORDS.acceleration_units.map((unit) => [unit, unit.replace("2", "²")]);
  const options = [["", "as stated in the file"], ...names];
  const units = el(
    "select",
    {},
    options.map(([value, text]) => el("option", { value }, text)),
  );

  async function upload() {
    const text = file.files?.[0];
    if (!text) return;
    fill(trouble);
    try {
      const type = /\.at2$/i.test(text.name) ? "text/plain" : "text/csv";
      const given = { name: text.name.slice(0, 200), units: units.value };
      const kept = await put(given, { method: "POST", body: text, headers: { "Content-Type": type } });
      await onKept(kept);
      say(`${kept.name} is chosen.`);
    } catch (error) {
      const faults = error instanceof Refusal ? error.faults : [];
      fill(trouble, faults.length ? faults.map((fault) => el("p", {}, faultText(fault))) : refusalBox(error));
    }
    file.value = "";
  }

  return [
    details(
      "Upload your own record",
      quiet("A PEER file (.at2), or two columns: time in seconds and acceleration (.csv)."),
      el(
        "div",
        { class: "row" },
        el("label", { class: "field" }, el("span", {}, "Unit of the acceleration"), units),
        el("label", { class: "field" }, el("span", {}, "File"), file),
      ),
    ),
    trouble,
  ];
}

/**
 * Figures of the chosen record. They are drawn when the user opens them.
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
    el("summary", {}, "Figures of the record"),
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
          xaxis: { title: "time [s]" },
          yaxis: { title: "acceleration [g]" },
          showlegend: false,
        }),
      );
      await spectrum.draw(
        () => [{ ...line, x: record.period_s, y: gs(record.pseudo_acceleration_m_s2), name: "spectrum" }],
        () => ({
          xaxis: { title: "natural period [s]", type: "log", dtick: "D2" },
          yaxis: { title: "pseudo-acceleration [g]", rangemode: "tozero" },
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
