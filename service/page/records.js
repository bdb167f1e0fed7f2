/** Ground-motion records: those that are there, and one's own from a file. */
/** @import { GroundRecord } from "./types.js" */

import { ask, faultText, Refusal, refusalBox } from "./api.js";
import { el, fill, say } from "./dom.js";
import { short } from "./numbers.js";
import { recordFigures } from "./record_figures.js";
import { WORDS } from "./words.js";

/**
 * Choose a record, or put up a file.
 *
 * @param {string} chosen id
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
 * Put a record up.
 *
 * @param {Record<string, string>} given
 * @param {RequestInit} options
 * @returns {Promise<GroundRecord>} as the service lists it
 */
async function put(given, options) {
  return /** @type {GroundRecord} */ (/** @type {unknown} */ (await ask("records", given, options)));
}

/**
 * A file of one's own to be kept as a record.
 *
 * @param {(kept: GroundRecord) => void | Promise<void>} onKept the record as the service lists it
 */
export function uploadField(onKept) {
  const trouble = el("div", { class: "upload faults", role: "alert" });
  const file = el("input", {
    type: "file",
    accept: ".at2,.AT2,.csv,.txt,text/plain,text/csv",
    onchange: () => upload(),
  });
  const names = WORDS.acceleration_units.map((unit) => [unit, unit.replace("2", "²")]);
  const options = [["", "as the file says"], ...names];
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
      const type = /\.csv$/i.test(text.name) ? "text/csv" : "application/octet-stream";
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
    el(
      "details",
      {},
      el("summary", {}, "Upload your own record"),
      el(
        "p",
        { class: "quiet" },
        "A PEER file (.at2), or two columns: time in seconds and acceleration (.csv).",
      ),
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
