/** What shakes the structure: one excitation, several that act one at a time, or ground-motion records. */

import { el, picker } from "./dom.js";
import { group, number, read, span } from "./specified.js";
import { recordsField } from "./survey_fields.js";
import { WORDS } from "./words.js";

/** @typedef {import("./specified.js").Held} Held */

const { motions, frequency, most, tail } = WORDS.specification.excitation;
const { measures, measures_under_records } = WORDS.specification.tables;
const PLACE = "excitation";

/** Kinds of excitation. */
const KINDS = /** @type {[string, string][]} */ ([["band", "over a band of frequencies"], ["records", "ground-motion records"]]);
/** What a form begins with that is told to be about the other kind. */
const BEGINNING = {
  band: { base_amplitude_m: 0.001, frequency_hz: 2.5 },
  records: { records: ["el-centro-180"], scales: 1 },
};
/** What is over an amplitude of the base, which records do not have. */
const IN_UNITS = { clearance_ratio: "clearance_m", friction_ratio: "friction_force_n" };

/** What shakes the structure: bands of frequencies, ground-motion records, or both. @param {Held} held */
export function shakenBy(held) {
  const every = [held.get(PLACE)].flat();
  const records = every.filter((/** @type {any} */ each) => each?.records !== undefined).length;
  return { bands: every.length > records, records: records > 0 };
}

/**
 * Every excitation in a group of its own, and what adds one; or records.
 *
 * @param {Held} held
 * @param {any[]} records those that the service has
 */
export function excitationFields(held, records) {
  const kind = shakenBy(held).bands ? "band" : "records";
  const change = (/** @type {string} */ next) => {
    held.set(PLACE, structuredClone(next === "records" ? BEGINNING.records : BEGINNING.band));
    held.set("measure", undefined);
    for (const ratio of Object.keys(next === "records" ? IN_UNITS : {})) for (const place of ["", "choose.", "tolerances."]) held.set(place + ratio, undefined);
    held.again();
  };
  const several = Array.isArray(held.get(PLACE));
  return [picker("Kind of excitation", KINDS, kind, change), kind === "records" && !several ? group("Ground-motion records", PLACE, recordFields(held, records, PLACE)) : bandFields(held, records)];
}

/** Records, their scales, and what follows them. @param {Held} held @param {any[]} records @param {string} place */
function recordFields(held, records, place) {
  const path = `${place}.scales`;
  const scales = held.get(path) ?? 1;
  const box = el("input", { type: "text", value: [scales].flat().join(", "), oninput: () => held.set(path, box.value.split(",").map((/** @type {string} */ part) => read(part, { name: "scale", label: "scale", unit: "", scale: 1 }))) });
  return [
    recordsField({ records: held.get(`${place}.records`) }, (_, value) => held.set(`${place}.records`, value), records, `${place}.records`),
    el("label", { class: "field", "data-field": path }, el("span", {}, "Scales, one after the other"), box, el("span", { class: "faults" })),
    number(held, `${place}.tail_s`, tail),
  ];
}

/** @param {Held} held @param {any[]} records */
function bandFields(held, records) {
  const raw = held.get(PLACE);
  const several = Array.isArray(raw);
  const count = several ? raw.length : 1;
  return [
    several
      ? raw.map((each, i) => oneOf(held, records, each, i))
      : group("Excitation", PLACE, fieldsAt(held, PLACE)),
    count < most && el(
      "div",
      { class: "row" },
      el("button", { type: "button", class: "small", onclick: () => add(held, likeLast(held)) }, "Add another excitation"),
      !shakenBy(held).records && el("button", { type: "button", class: "small", onclick: () => add(held, structuredClone(BEGINNING.records)) }, "Add ground-motion records"),
    ),
    several && el("p", { class: "quiet" }, "They act one at a time; the worst of them is judged."),
  ];
}

/** One of several excitations. @param {Held} held @param {any[]} records @param {any} each @param {number} i */
function oneOf(held, records, each, i) {
  const place = `${PLACE}.${i}`;
  const fields = each?.records === undefined ? fieldsAt(held, place) : recordFields(held, records, place);
  return group(`Excitation ${i + 1}${each?.records === undefined ? "" : ": ground-motion records"}`, place, [nameField(held, i), ...fields, remover(held, i)]);
}

/** One excitation over a band, like the last that there is. @param {Held} held */
function likeLast(held) {
  const over = [held.get(PLACE) ?? {}].flat().filter((/** @type {any} */ each) => each?.records === undefined);
  const { name, ...like } = over[over.length - 1] ?? BEGINNING.band;
  return structuredClone(like);
}

/** One excitation more: a list begins with the one that is there. @param {Held} held @param {any} more */
function add(held, more) {
  held.set(PLACE, [...[held.get(PLACE) ?? {}].flat(), more]);
  dropMeasure(held);
  held.again();
}

/** Take a measure away that what shakes the structure now does not have. @param {Held} held */
function dropMeasure(held) {
  if (!(held.get("measure") in measuresOf(held))) held.set("measure", undefined);
}

/** What can be asked for under all that shakes the structure. @param {Held} held @returns {Record<string, string>} */
export function measuresOf(held) {
  const { bands, records } = shakenBy(held);
  if (!records) return measures;
  if (!bands) return measures_under_records;
  return Object.fromEntries(Object.entries(measures).filter(([name]) => name in measures_under_records));
}

/** @param {Held} held @param {number} i */
function remover(held, i) {
  const remove = () => {
    const left = held.get(PLACE).filter((/** @type {any} */ _, /** @type {number} */ k) => k !== i);
    const { name, ...only } = left[0] ?? {};
    held.set(PLACE, left.length > 1 ? left : only);
    dropMeasure(held);
    held.again();
  };
  return el("button", { type: "button", class: "small", "aria-label": `Remove excitation ${i + 1}`, onclick: remove }, "Remove");
}

/** @param {Held} held @param {number} i */
function nameField(held, i) {
  const path = `${PLACE}.${i}.name`;
  const box = el("input", { type: "text", value: held.get(path) ?? "", placeholder: `excitation ${i + 1}`, oninput: () => held.set(path, box.value || undefined) });
  return el("label", { class: "field", "data-field": path }, el("span", {}, "Name"), box, el("span", { class: "faults" }));
}

/** What is constant over the band, how much of it, and the band. @param {Held} held @param {string} place */
function fieldsAt(held, place) {
  const has = (/** @type {string} */ name) => held.get(`${place}.${name}`) !== undefined;
  const now = motions.find((each) => has(each.name)) ?? motions[0];
  const change = (/** @type {string} */ name) => {
    held.set(`${place}.${now.name}`, undefined);
    held.set(`${place}.${name}`, 1);
    held.again();
  };
  const given = frequency.filter((each) => has(each.name));
  return [
    picker("Constant over the band", motions.map((each) => [each.name, each.label]), now.name, change),
    span(held, `${place}.${now.name}`, now),
    ...(given.length ? given : frequency.slice(0, 1)).map((each) => span(held, `${place}.${each.name}`, each)),
  ];
}
