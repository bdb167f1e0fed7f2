/** Form fields for the settings of a study: excitation, cavity, contact, starts, and steady response. */
/** @import { Definition, Spec } from "./types.js" */

import { axisField } from "./axis_field.js";
import { capital, el, picker, quiet } from "./dom.js";
import { field } from "./faults.js";
import { help } from "./help.js";
import { WORDS } from "./words.js";

/** The initial settings of each kind of start. @type {Record<string, object>} */
const STARTS = { ensemble: { n: 10, seed: 0 }, continuation: { direction: "up" } };

/**
 * A field for a number, with a label.
 *
 * @param {string} label
 * @param {string} path
 * @param {number | undefined} value
 * @param {(value: number) => void} onChange
 */
export function numberField(label, path, value, onChange) {
  const box = el("input", { type: "number", step: "any", value, oninput: () => onChange(Number(box.value)) });
  return field(path, label, box);
}

/** The field for the tilt of the cavity or the friction of the particle. @param {string} name */
export function cavityField(name) {
  const about = WORDS.fitted.find((each) => each.name === name);
  if (!about) throw new Error(`no words for ${name}`);
  return { ...about, label: capital(about.label) };
}

/**
 * The fields for the friction of the particle and for gravity in the cavity. A value of 0 is not written into
 * the study.
 *
 * @param {Definition} study
 * @param {(path: string, value: unknown) => void} change
 */
export function cavityFields(study, change) {
  return Object.entries(WORDS.before).map(([ratio, quantity]) => {
    const name = study.physical && study[ratio] === undefined ? quantity : ratio;
    const about = cavityField(name);
    const slider = about.unit === "°" ? { high: 90, step: 1 } : { high: 1, step: 0.01 };
    const looks = { ...about, field: about.path, low: 0, usual: 0, ...slider };
    const spec = /** @type {Spec} */ ((name === ratio ? study : study.physical)?.[name] ?? 0);
    return axisField(looks, spec, (value) => change(about.path, value === 0 ? undefined : value));
  });
}

/** The field of the excitation. @param {Definition} study @param {(study: Definition) => void} redraw */
export function excitationField(study, redraw) {
  const now = study.excitation ?? "base";
  const put = (/** @type {string} */ next) =>
    redraw({ ...study, excitation: next === "base" ? undefined : next });
  return el(
    "div",
    { class: "row", "data-field": "excitation" },
    picker("The structure is excited by", Object.entries(WORDS.excitations), now, put),
    help("model/#a-force-on-the-structure", "a force on the structure"),
    el("span", { class: "faults" }),
    now === "force" &&
      quiet(
        "The base stands still. Z is the static displacement F₀/k: γ_F = F_f/F₀, and the amplitude " +
          "ratio is X k/F₀.",
      ),
  );
}

/**
 * The fields of the contact.
 *
 * @param {Definition} study
 * @param {(path: string, value: unknown) => void} change
 * @param {(study: Definition) => void} redraw
 */
export function contactField(study, change, redraw) {
  const contact = study.contact ?? { model: "instant" };
  const models = Object.entries(WORDS.contact_models);
  if (!models.some(([model]) => model === contact.model)) models.push([contact.model, contact.model]);
  const put = (/** @type {Definition["contact"]} */ next) => redraw({ ...study, contact: next });
  return el(
    "div",
    { class: "row", "data-field": "contact" },
    picker("Model of an impact", models, contact.model, (model) =>
      put(model === "instant" ? { model } : { model, contact_time: 0.5 }),
    ),
    contact.model !== "instant" &&
      numberField("Contact time × ω_n", "contact.contact_time", contact.contact_time, (time) =>
        change("contact.contact_time", time),
      ),
    help("contact/", "contact models"),
    el("span", { class: "faults" }),
  );
}

/**
 * The fields for the initial state of each point.
 *
 * @param {Definition} study
 * @param {(path: string, value: unknown) => void} change
 * @param {(study: Definition) => void} redraw
 */
export function startField(study, change, redraw) {
  const { start: given = "rest" } = study;
  const start = typeof given === "string" ? { kind: given } : given;
  const { kind } = start;
  const put = (/** @type {Definition["start"]} */ next) => redraw({ ...study, start: next });
  return el(
    "div",
    { class: "row", "data-field": "start" },
    picker("Each point starts", Object.entries(WORDS.start_kinds), kind, (chosen) =>
      put(chosen in STARTS ? { kind: chosen, ...STARTS[chosen] } : chosen),
    ),
    kind === "ensemble" && numberField("Number of starts", "start.n", start.n, (n) => change("start.n", n)),
    kind === "continuation" &&
      picker(
        "Direction of the continuation",
        [
          ["up", "up"],
          ["down", "down"],
        ],
        start.direction ?? "up",
        (direction) => put({ ...start, direction }),
      ),
    el("span", { class: "faults" }),
  );
}

/**
 * The fields for the criterion by which a response is accepted as steady.
 *
 * @param {Definition} study
 * @param {(path: string, value: unknown) => void} change
 */
export function steadyField(study, change) {
  const steady = study.steady ?? {};
  return el(
    "div",
    { class: "row" },
    numberField(
      "Largest number of cycles per point",
      "steady.max_cycles",
      steady.max_cycles ?? WORDS.steady.max_cycles,
      (value) => change("steady.max_cycles", value),
    ),
    numberField(
      "Tolerance of the mean",
      "steady.tolerance",
      steady.tolerance ?? WORDS.steady.tolerance,
      (value) => change("steady.tolerance", value),
    ),
  );
}
