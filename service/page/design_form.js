/** The form of a new design: the fields of its specification, and the budget of the search. */
/** @import { GroundRecord, Held, SpecifiedField, View } from "./types.js" */

import { ask, designPath } from "./api.js";
import { documentForm } from "./document_form.js";
import { el, picker, prose, say } from "./dom.js";
import { excitationFields, measuresOf, shakenBy } from "./excitation_fields.js";
import { field } from "./faults.js";
import { help } from "./help.js";
import { SEMICOLON } from "./lists.js";
import { count, short } from "./numbers.js";
import { modelSketch } from "./model_sketch.js";
import { group, number, numbers as listOf, read, shown, span, titled } from "./specified.js";
import { vocabulary } from "./vocabulary.js";
import { WORDS } from "./words.js";

const { structure, damper, ratios, limits, numbers, contact_time: contactTime } = WORDS.specification;
/** Ways to state a quantity of the damper, with their labels. */
const WAYS = /** @type {[string, string][]} */ ([
  ["given", "given"],
  ["range", "in a range"],
  ["list", "from a list"],
]);

/** @typedef {Record<string, number | string>} Named a value with a name */

/** The example with which an empty form begins. */
const EMPTY = {
  name: "your own machine",
  about: [
    "The structure, its excitation and the ranges of the damper, in the units of a drawing. The " +
    "other choices are examples.",
  ],
  definition: { name: "", structure: {}, excitation: {}, choose: { clearance_m: {}, friction_force_n: {} } },
  empty: true,
};

/** @type {View} */
export async function designForm(root, { query }) {
  const [{ specifications }, { records }] = await Promise.all([vocabulary(), ask("records")]);
  const from = query.get("from");
  const copied = from === null ? [] : [await copy(from)];
  return documentForm(root, {
    title: "New design",
    help: help("how-to/design/#what-a-specification-holds", "specifications"),
    json: "The specification as JSON",
    path: "designs",
    submit: "Find the damper",
    cost: "Budget",
    can: "be searched",
    starts: [...copied, EMPTY, ...specifications],
    first: copied[0]?.name ?? query.get("specification") ?? EMPTY.name,
    done: ({ id }) => {
      say("The design was requested.");
      location.hash = `#/designs/${id}`;
    },
    beside: el("section", { class: "box", "aria-label": "The model" }, modelSketch()),
    fields: (held) => fieldsOf(held, records),
    estimated: ({ chosen, budget_points: budget, understood }) =>
      prose(
        `To be chosen: ${chosen.map(labelOf).join("; ")}. ` +
          [`At most ${count(budget)} points.`, ...understood].join(" "),
      ),
  });
}

/** A copy of the specification of an existing design, with which the form begins. @param {string} id */
async function copy(id) {
  const design = await ask(designPath(id));
  const name = design.name || design.id;
  return {
    name: `copy of ${name}`,
    about: [`A copy of ${name}. Points that it shares with the original are not computed again.`],
    definition: { ...design.specification, name: `${name}, changed` },
  };
}

/** The name of a quantity of the damper. @param {string} name */
function labelOf(name) {
  return damper.find((each) => each.name === name)?.label ?? name;
}

/**
 * Every field of a specification.
 *
 * @param {Held} held
 * @param {GroundRecord[]} records ground-motion records of the service
 */
function fieldsOf(held, records) {
  const measures = measuresOf(held);
  // fields of the document are shown even if they are not valid
  const { bands } = shakenBy(held);
  const limited = limits.filter(
    (each) => !each.over_bands || bands || held.get(`limits.${each.name}`) !== undefined,
  );
  const name = el("input", {
    type: "text",
    value: held.get("name") ?? "",
    oninput: () => held.set("name", name.value),
  });
  return [
    field("name", "Name", name, { wide: true }),
    group(
      "Structure",
      "structure",
      structure
        .filter((each) => each.usual || held.get(`structure.${each.name}`) !== undefined)
        .map((each) => [number(held, `structure.${each.name}`, each), each.loose && tolerance(held, each)]),
    ),
    excitationFields(held, records),
    ...damper.map((each) => damperField(held, each)),
    group("Contact", contactTime.name, [number(held, contactTime.name, contactTime)]),
    group(
      "Limits",
      "limits",
      limited.map((each) => number(held, `limits.${each.name}`, each)),
    ),
    group("What is judged", "measure", [
      picker("Minimise", Object.entries(measures), held.get("measure") ?? Object.keys(measures)[0], (value) =>
        held.set("measure", value),
      ),
      ...numbers.map((each) => number(held, each.name, each)),
    ]),
  ];
}

/**
 * The fields of a quantity of the damper: its value or its allowed values, and its tolerance.
 *
 * @param {Held} held
 * @param {SpecifiedField & {ratio: string}} unit
 */
function damperField(held, unit) {
  const inRatio =
    [unit.ratio, `choose.${unit.ratio}`].some((path) => held.get(path) !== undefined) &&
    unit.ratio !== unit.name;
  const each = inRatio ? ratios[unit.ratio] : unit;
  const place = `choose.${each.name}`;
  /** @type {unknown} */
  const chosen = held.get(place);
  const way = chosen === undefined ? "given" : Array.isArray(chosen) ? "list" : "range";
  const change = (/** @type {string} */ next) => {
    const values = numbersIn(held.get(place) ?? held.get(each.name) ?? 0, each);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const stop = high > low ? high : low + (low || 1);
    held.set(each.name, next === "given" ? low : undefined);
    held.set(place, next === "range" ? { start: low, stop } : next === "list" ? [low, stop] : undefined);
    held.again();
  };
  const inputs =
    way === "given"
      ? number(held, each.name, each, "Value")
      : way === "range"
        ? span(held, place, each, "From and to")
        : list(held, place, each);
  return el(
    "fieldset",
    { "data-field": each.name },
    el("legend", {}, titled(each)),
    el("div", { class: "pairs" }, picker("It is", WAYS, way, change), inputs, tolerance(held, each)),
    el("div", { class: "faults" }),
  );
}

/**
 * A field for a list of values, each of which may have a name.
 *
 * @param {Held} held
 * @param {string} path
 * @param {SpecifiedField} each
 */
function list(held, path, each) {
  const time = contactTime.name;
  const one = (/** @type {number | Named} */ value) => {
    if (typeof value !== "object") return shown(value, each);
    const ms = value[time] ? ` (${short(1e3 * Number(value[time]), 4)} ms)` : "";
    return `${value.name ?? ""} ${shown(value[each.name], each)}${ms}`.trim();
  };
  /** @param {string} part */
  function entry(part) {
    const [, name, value, ms] = /^\s*(.*?)\s*([^\s(]*)\s*(?:\(\s*(\S+)\s*ms\s*\))?\s*$/.exec(part) ?? [];
    const found = read(value, each) ?? null;
    return name || ms
      ? { ...(name ? { name } : {}), [each.name]: found, ...(ms ? { [time]: Number(ms) / 1e3 } : {}) }
      : found;
  }
  const title =
    each.name === "restitution"
      ? "Values, with names as in rubber 0.3, steel 0.8; with a contact time as in rubber 0.3 (4 ms)"
      : "Values, with names as in light 1.2, heavy 2.5";
  const value = /** @type {(number | Named)[]} */ (held.get(path)).map(one).join(", ");
  return listOf(held, path, each, { title, value, between: SEMICOLON, entry });
}

/**
 * The numbers in a value, a range, or a list whose values may have names.
 *
 * @param {unknown} said
 * @param {SpecifiedField} each
 */
function numbersIn(said, each) {
  const { start, stop } = /** @type {Record<string, unknown>} */ (said);
  const list = Array.isArray(said) ? said : typeof said === "object" ? [start, stop] : [said];
  return list.map((one) => Number(typeof one === "object" ? one[each.name] : one));
}

/** The field for a tolerance, as a number or in per cent. @param {Held} held @param {SpecifiedField} each */
function tolerance(held, each) {
  const path = `tolerances.${each.name}`;
  const value = held.get(path);
  const box = el("input", {
    type: "text",
    value: typeof value === "string" ? value : shown(value, each),
    placeholder: "exact",
    oninput: () => held.set(path, box.value.includes("%") ? box.value.trim() : read(box.value, each)),
  });
  const title = `± ${each.unit ? `${each.unit}, or a share` : "the number, or a share"} as 10%`;
  return field(path, title, box, { ...each, label: `tolerance of the ${each.label}` });
}
