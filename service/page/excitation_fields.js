/** What shakes the structure: one excitation, several that act one at a time, or ground-motion records. */

import { el, picker } from "./dom.js";
import { group, number, read, span } from "./specified.js";
import { recordsField } from "./survey_fields.js";
import { WORDS } from "./words.js";

/** @typedef {import("./specified.js").Held} Held */

const { motions, frequency, most, tail } = WORDS.specification.excitation;
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

/** Whether ground-motion records shake the structure. @param {Held} held */
export function underRecords(held) {
  return held.get(`${PLACE}.records`) !== undefined;
}

/**
 * Every excitation in a group of its own, and what adds one; or records.
 *
 * @param {Held} held
 * @param {any[]} records those that the service has
 */
export function excitationFields(held, records) {
  const kind = underRecords(held) ? "records" : "band";
  const change = (/** @type {string} */ next) => {
    held.set(PLACE, structuredClone(next === "records" ? BEGINNING.records : BEGINNING.band));
    held.set("measure", undefined);
    for (const ratio of Object.keys(next === "records" ? IN_UNITS : {})) for (const place of ["", "choose.", "tolerances."]) held.set(place + ratio, undefined);
    held.again();
  };
  return [picker("Kind of excitation", KINDS, kind, change), kind === "records" ? recordFields(held, records) : bandFields(held)];
}

/** Records, their scales, and what follows them. @param {Held} held @param {any[]} records */
function recordFields(held, records) {
  const path = `${PLACE}.scales`;
  const scales = held.get(path) ?? 1;
  const box = el("input", { type: "text", value: [scales].flat().join(", "), oninput: () => held.set(path, box.value.split(",").map((/** @type {string} */ part) => read(part, { name: "scale", label: "scale", unit: "", scale: 1 }))) });
  return group("Ground-motion records", PLACE, [
    recordsField({ records: held.get(`${PLACE}.records`) }, (_, value) => held.set(`${PLACE}.records`, value), records, `${PLACE}.records`),
    el("label", { class: "field", "data-field": path }, el("span", {}, "Scales, one after the other"), box, el("span", { class: "faults" })),
    number(held, `${PLACE}.tail_s`, tail),
  ]);
}

/** @param {Held} held */
function bandFields(held) {
  const raw = held.get(PLACE);
  const several = Array.isArray(raw);
  const count = several ? raw.length : 1;
  return [
    several
      ? raw.map((_, i) => group(`Excitation ${i + 1}`, `${PLACE}.${i}`, [nameField(held, i), ...fieldsAt(held, `${PLACE}.${i}`), remover(held, i)]))
      : group("Excitation", PLACE, fieldsAt(held, PLACE)),
    count < most && el("div", { class: "row" }, el("button", { type: "button", class: "small", onclick: () => add(held) }, "Add another excitation")),
    several && el("p", { class: "quiet" }, "They act one at a time; the worst of them is judged."),
  ];
}

/** One excitation more, like the last: a list begins with the one that is there. @param {Held} held */
function add(held) {
  const raw = held.get(PLACE);
  const given = Array.isArray(raw) ? raw : [raw ?? {}];
  const { name, ...like } = given[given.length - 1] ?? {};
  held.set(PLACE, [...given, structuredClone(like)]);
  held.again();
}

/** @param {Held} held @param {number} i */
function remover(held, i) {
  const remove = () => {
    const left = held.get(PLACE).filter((/** @type {any} */ _, /** @type {number} */ k) => k !== i);
    const { name, ...only } = left[0] ?? {};
    held.set(PLACE, left.length > 1 ? left : only);
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
