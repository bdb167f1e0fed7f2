/**
 * The fields of the excitations of a specification: bands of frequencies, and stored or generated records.
 */
/** @import { GroundRecord, Held, SpecifiedField } from "./types.js" */

import { el, picker, quiet, smallButton } from "./dom.js";
import { field } from "./faults.js";
import { group, number, numbers, span } from "./specified.js";
import { recordsField } from "./survey_fields.js";
import { WORDS } from "./words.js";

/** @typedef {"band" | "sweep" | "random_vibration" | "shock" | "records"} Kind */

const { motions, frequency, sweep, random_vibration, shock, most, tail } = WORDS.specification.excitation;
const { measures, measures_under_records } = WORDS.specification.tables;
const PLACE = "excitation";

/** Kinds of excitation, with their labels. */
const KINDS = /** @type {[string, string][]} */ ([
  ["band", "over a band of frequencies"],
  ["sweep", "a sweep"],
  ["random_vibration", "random vibration"],
  ["shock", "a shock"],
  ["records", "ground-motion records"],
]);
const TITLES = {
  band: "Excitation",
  sweep: "Sweep",
  random_vibration: "Random vibration",
  shock: "Shock",
  records: "Ground-motion records",
};
/** The values with which the form of each kind of excitation begins. */
const BEGINNING = {
  band: { base_amplitude_m: 0.001, frequency_hz: 2.5 },
  sweep: { sweep: { start_hz: 2, stop_hz: 3, rate_hz_per_s: 0.1, base_amplitude_m: 0.001 } },
  random_vibration: {
    random_vibration: { frequency_hz: [1, 50], psd_g2_per_hz: [0.0001, 0.0001], duration_s: 30, seeds: 4 },
  },
  shock: { shock: { shape: "half_sine", peak_g: 5, duration_ms: 11 } },
  records: { records: ["el-centro-180"], scales: 1 },
};
/** @param {string} kind */
const beginning = (kind) => structuredClone(BEGINNING[/** @type {Kind} */ (kind)]);
/** Kinds of excitation that are generated records. */
const GENERATED = /** @type {Kind[]} */ (["sweep", "random_vibration", "shock"]);
/** Initial values of the alternative fields of a sweep: for example, the duration may replace the rate. */
const USUAL = /** @type {Record<string, number>} */ ({
  rate_hz_per_s: 0.1,
  rate_octaves_per_minute: 1,
  duration_s: 30,
  base_amplitude_m: 0.001,
  base_velocity_m_per_s: 0.05,
  base_acceleration_m_per_s2: 1,
});
/** Quantities in units that replace ratios to the base amplitude, because records have no base amplitude. */
const IN_UNITS = { clearance_ratio: "clearance_m", friction_ratio: "friction_force_n" };

/** @typedef {Record<string, unknown>} Excitation */

/** The kind of one excitation. @param {Excitation | undefined} each @returns {Kind} */
function kindOf(each) {
  const kind = [...GENERATED, /** @type {Kind} */ ("records")].find((name) => each?.[name] !== undefined);
  return kind ?? "band";
}

/** The excitations of the document, or a list with one empty object if there are none. @param {Held} held */
function allOf(held) {
  return [/** @type {Excitation | Excitation[]} */ (held.get(PLACE) ?? {})].flat();
}

/** Whether the excitations include bands, and whether they include records. @param {Held} held */
export function shakenBy(held) {
  const kinds = allOf(held).map(kindOf);
  return { bands: kinds.includes("band"), records: kinds.some((kind) => kind !== "band") };
}

/**
 * A picker of the kind of excitation, and the fields of every excitation.
 *
 * @param {Held} held
 * @param {GroundRecord[]} records ground-motion records of the service
 */
export function excitationFields(held, records) {
  const all = allOf(held);
  const kind = kindOf(all.find((each) => kindOf(each) === "band") ?? all[0]);
  const change = (/** @type {string} */ next) => {
    held.set(PLACE, beginning(next));
    held.set("measure", undefined);
    for (const ratio of Object.keys(next === "band" ? {} : IN_UNITS))
      for (const place of ["", "choose.", "tolerances."]) held.set(place + ratio, undefined);
    held.again();
  };
  return [picker("Kind of excitation", KINDS, kind, change), everyOne(held, records)];
}

/** @param {Held} held @param {GroundRecord[]} records @param {string} place @param {Kind} kind */
function fieldsOfKind(held, records, place, kind) {
  if (kind === "band") return fieldsAt(held, place);
  if (kind === "records") return recordFields(held, records, place);
  const fields = { sweep: sweepFields, random_vibration: vibrationFields, shock: shockFields }[kind];
  return [...fields(held, `${place}.${kind}`), ...scaleFields(held, place)];
}

/**
 * The fields of a sweep: its ends, its rate, and the quantity that stays constant.
 *
 * @param {Held} held
 * @param {string} path
 */
function sweepFields(held, path) {
  return [
    ...sweep.ends.map((each) => number(held, `${path}.${each.name}`, each)),
    ...oneFieldOf(held, path, "How fast", sweep.paces),
    ...oneFieldOf(held, path, "Constant in the sweep", sweep.amplitudes),
  ];
}

/** The fields of random vibration: spectrum, duration, seeds. @param {Held} held @param {string} path */
function vibrationFields(held, path) {
  return [
    list(held, `${path}.frequency_hz`, random_vibration.frequency),
    ...oneFieldOf(held, path, "Unit of the levels", random_vibration.levels, list),
    ...random_vibration.numbers.map((each) => number(held, `${path}.${each.name}`, each)),
  ];
}

/** The fields of a shock: shape, size and length of the pulse. @param {Held} held @param {string} path */
function shockFields(held, path) {
  const change = (/** @type {string} */ shape) => held.set(`${path}.shape`, shape);
  return [
    picker("Shape of the pulse", Object.entries(shock.shapes), held.get(`${path}.shape`) ?? "", change),
    ...shock.numbers.map((each) => number(held, `${path}.${each.name}`, each)),
  ];
}

/**
 * A field for numbers that are separated by commas.
 *
 * @param {Held} held
 * @param {string} path
 * @param {SpecifiedField} each
 * @param {unknown} [usual]
 */
function list(held, path, each, usual = "") {
  return numbers(held, path, each, { value: [held.get(path) ?? usual].flat().join(", ") });
}

/**
 * A picker with which one of several fields is chosen, and the box of the chosen field.
 *
 * @param {Held} held
 * @param {string} path
 * @param {string} title
 * @param {SpecifiedField[]} fields
 * @param {(held: Held, path: string, each: SpecifiedField) => HTMLElement} [drawn]
 */
function oneFieldOf(held, path, title, fields, drawn = number) {
  const now = fields.find((each) => held.get(`${path}.${each.name}`) !== undefined) ?? fields[0];
  const change = (/** @type {string} */ name) => {
    const value = USUAL[name] ?? held.get(`${path}.${now.name}`);
    held.set(`${path}.${now.name}`, undefined);
    held.set(`${path}.${name}`, value);
    held.again();
  };
  return [
    picker(
      title,
      fields.map((each) => [each.name, each.label]),
      now.name,
      change,
    ),
    drawn(held, `${path}.${now.name}`, now),
  ];
}

/**
 * The fields of records: the records, their scales, and the computed time after a record.
 *
 * @param {Held} held
 * @param {GroundRecord[]} records
 * @param {string} place
 */
function recordFields(held, records, place) {
  return [
    recordsField(
      { records: held.get(`${place}.records`) },
      (_, value) => held.set(`${place}.records`, value),
      records,
      `${place}.records`,
    ),
    ...scaleFields(held, place),
  ];
}

/** @param {Held} held @param {string} place */
function scaleFields(held, place) {
  return [
    list(
      held,
      `${place}.scales`,
      { name: "scales", label: "scales, one after the other", unit: "", scale: 1 },
      1,
    ),
    number(held, `${place}.tail_s`, tail),
  ];
}

/**
 * Every excitation in its own group, with buttons that add a further excitation.
 *
 * @param {Held} held
 * @param {GroundRecord[]} records
 */
function everyOne(held, records) {
  const all = allOf(held);
  const several = Array.isArray(held.get(PLACE));
  const kind = kindOf(all[0]);
  return [
    several
      ? all.map((each, i) => oneOf(held, records, each, i))
      : group(TITLES[kind], PLACE, fieldsOfKind(held, records, PLACE, kind)),
    all.length < most &&
      el(
        "div",
        { class: "row" },
        smallButton("Add another excitation", () => add(held, likeLast(held))),
        KINDS.filter(([name]) => GENERATED.includes(/** @type {Kind} */ (name))).map(([name, words]) =>
          smallButton(`Add ${words}`, () => add(held, beginning(name))),
        ),
        !all.some((each) => kindOf(each) === "records") &&
          smallButton("Add ground-motion records", () => add(held, beginning("records"))),
      ),
    several && quiet("They act one at a time; the worst of them is judged."),
  ];
}

/**
 * The group of one excitation, if there are several.
 *
 * @param {Held} held
 * @param {GroundRecord[]} records
 * @param {Excitation} each
 * @param {number} i
 */
function oneOf(held, records, each, i) {
  const place = `${PLACE}.${i}`;
  const kind = kindOf(each);
  const title = kind === "band" ? "" : `: ${TITLES[kind].toLowerCase()}`;
  return group(`Excitation ${i + 1}${title}`, place, [
    nameField(held, i),
    ...fieldsOfKind(held, records, place, kind),
    remover(held, i),
  ]);
}

/** A new excitation over a band, with the values of the last excitation over a band. @param {Held} held */
function likeLast(held) {
  const over = allOf(held).filter((each) => kindOf(each) === "band");
  const { name, ...like } = /** @type {Excitation} */ (over[over.length - 1] ?? BEGINNING.band);
  return structuredClone(like);
}

/** Add an excitation; all excitations then form a list. @param {Held} held @param {unknown} more */
function add(held, more) {
  held.set(PLACE, [...allOf(held), more]);
  dropMeasure(held);
  held.again();
}

/** Remove the chosen measure if the present excitations do not have this measure. @param {Held} held */
function dropMeasure(held) {
  if (!(String(held.get("measure")) in measuresOf(held))) held.set("measure", undefined);
}

/**
 * The measures by which dampers can be judged under all excitations of the document.
 *
 * @param {Held} held
 * @returns {Record<string, string>}
 */
export function measuresOf(held) {
  const { bands, records } = shakenBy(held);
  if (!records) return measures;
  if (!bands) return measures_under_records;
  return Object.fromEntries(Object.entries(measures).filter(([name]) => name in measures_under_records));
}

/** @param {Held} held @param {number} i */
function remover(held, i) {
  const remove = () => {
    const left = allOf(held).filter((_, k) => k !== i);
    const { name, ...only } = left[0] ?? {};
    held.set(PLACE, left.length > 1 ? left : only);
    dropMeasure(held);
    held.again();
  };
  return smallButton("Remove", remove, `Remove excitation ${i + 1}`);
}

/** @param {Held} held @param {number} i */
function nameField(held, i) {
  const path = `${PLACE}.${i}.name`;
  const box = el("input", {
    type: "text",
    value: held.get(path) ?? "",
    placeholder: `excitation ${i + 1}`,
    oninput: () => held.set(path, box.value || undefined),
  });
  return field(path, "Name", box);
}

/** The fields of a band: constant quantity and frequencies. @param {Held} held @param {string} place */
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
    picker(
      "Constant over the band",
      motions.map((each) => [each.name, each.label]),
      now.name,
      change,
    ),
    span(held, `${place}.${now.name}`, now),
    ...(given.length ? given : frequency.slice(0, 1)).map((each) =>
      span(held, `${place}.${each.name}`, each),
    ),
  ];
}
