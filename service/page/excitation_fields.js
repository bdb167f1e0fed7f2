/** What shakes the structure: one excitation, or several that act one at a time. */

import { el, picker } from "./dom.js";
import { group, span } from "./specified.js";
import { WORDS } from "./words.js";

/** @typedef {import("./specified.js").Held} Held */

const { motions, frequency, most } = WORDS.specification.excitation;
const PLACE = "excitation";

/** Every excitation in a group of its own, and what adds one. @param {Held} held */
export function excitationFields(held) {
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
