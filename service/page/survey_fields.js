/** The fields of a ground-motion suite, a study of dampers under scaled records. */
/** @import { Definition, GroundRecord, Quantity } from "./types.js" */

import { axisField } from "./axis_field.js";
import { checkbox, el, fill } from "./dom.js";
import { field } from "./faults.js";
import { short } from "./numbers.js";
import { PHYSICAL, RATIOS } from "./quantities.js";
import { recordFigures, uploadField } from "./records.js";
import { cavityField, contactField, numberField } from "./settings_fields.js";
import { WORDS } from "./words.js";

/** Records with which a new suite begins. */
const FIRST = ["el-centro-180", "loma-prieta-000", "northridge-090", "san-fernando-164"];

/** @type {Record<string, Quantity>} */
const AXES = Object.fromEntries(
  [
    { ...PHYSICAL.clearance_m, field: "axes.clearance_m" },
    { ...PHYSICAL.friction_force_n, field: "axes.friction_force_n", high: 10 },
    { ...PHYSICAL.particle_mass_kg, field: "axes.particle_mass_kg" },
    { ...RATIOS.restitution, field: "axes.restitution" },
    { field: "axes.scale", label: "Factor on the records", low: 0.1, high: 4, step: 0.1, usual: 1 },
    { ...PHYSICAL.natural_frequency_hz, field: "axes.natural_frequency_hz" },
    { ...RATIOS.damping_ratio, field: "axes.damping_ratio" },
  ].map((quantity) => [quantity.field.split(".")[1], quantity]),
);

/** The entry for a suite in the list of studies from which a new study may start. */
export const SURVEY = {
  name: "ground-motion suite",
  about: [
    "Dampers under ground-motion records, scaled up step by step: which damper is best under its worst " +
      "record, and how likely each damper is to exceed a limit.",
  ],
  definition: {
    name: "ground-motion suite",
    records: FIRST,
    axes: {
      clearance_m: { start: 0.005, stop: 0.02, num: 4 },
      friction_force_n: [0, 0.5, 1, 2, 4],
      scale: { start: 0.25, stop: 2, num: 8 },
    },
  },
};

/**
 * Every field of a suite.
 *
 * @param {Definition} study
 * @param {(path: string, value: unknown) => void} change
 * @param {(study: Definition) => void} redraw
 * @param {GroundRecord[]} records ground-motion records of the service
 */
export function surveyFields(study, change, redraw, records) {
  const name = el("input", {
    type: "text",
    maxlength: 200,
    value: study.name ?? "",
    oninput: () => change("name", name.value),
  });
  const usual = (/** @type {string} */ key) => PHYSICAL[key]?.usual;
  return [
    field("name", "Name", name, { wide: true }),
    recordsField(study, change, records),
    Object.entries(AXES).map(([key, quantity]) => {
      // a missing value is the value of the paper's prototype
      const spec = study.axes?.[key] ?? quantity.usual / (quantity.scale ?? 1);
      return axisField(quantity, spec, (value) => change(quantity.field, value));
    }),
    el(
      "div",
      { class: "row" },
      numberField("Mass of the structure M [kg]", "mass_kg", study.mass_kg ?? usual("mass_kg"), (value) =>
        change("mass_kg", value),
      ),
      numberField("Free vibration after the record [s]", "tail_s", study.tail_s ?? 0, (value) =>
        change("tail_s", value),
      ),
    ),
    el(
      "details",
      { class: "more" },
      el("summary", {}, "Cavity, contact and perturbed starts"),
      el(
        "div",
        { class: "row" },
        Object.values(WORDS.before).map((name) =>
          numberField(cavityField(name).label, name, Number(study[name] ?? 0), (value) =>
            change(name, value || undefined),
          ),
        ),
      ),
      contactField(study, change, redraw),
      el(
        "div",
        { class: "row" },
        numberField("Perturbed starts of each case", "starts", study.starts ?? 0, (value) =>
          change("starts", value),
        ),
      ),
    ),
  ];
}

/**
 * Fields to choose among all records, and to upload a file.
 *
 * @param {{records?: unknown}} study
 * @param {(path: string, value: unknown) => void} change
 * @param {GroundRecord[]} records ground-motion records of the service
 * @param {string} [field] path of the field at which faults of records are shown
 */
export function recordsField(study, change, records, field = "records") {
  const chosen = new Set(ids(study.records).map((id) => whole(id, records)));
  const boxes = el("div", { class: "checks" });
  const looks = recordFigures();
  function draw() {
    fill(
      boxes,
      records.map((one) =>
        checkbox(
          `${one.name} (${short(one.peak_acceleration_g, 2)} g, ${short(one.duration_s, 3)} s)`,
          chosen.has(one.id),
          (on) => choose(one.id, on),
        ),
      ),
    );
  }
  /** @param {string} id @param {boolean} on */
  function choose(id, on) {
    if (on) looks.show(id);
    if (on) chosen.add(id);
    else chosen.delete(id);
    change("records", [...chosen]);
  }
  draw();
  const [first] = chosen;
  if (first) looks.show(first);
  const upload = uploadField((kept) => {
    if (!records.some((one) => one.id === kept.id)) records.push(kept);
    choose(kept.id, true);
    draw();
  });
  return el(
    "fieldset",
    { class: "fields", "data-field": field },
    el("legend", {}, "Records"),
    boxes,
    upload,
    looks.element,
    el("div", { class: "faults" }),
  );
}

/**
 * The ids of the records of a document. A record is given by its id, or by an object as in a stored study.
 *
 * @param {unknown} given
 * @returns {string[]}
 */
function ids(given) {
  return (Array.isArray(given) ? given : [given]).flatMap((one) =>
    typeof one === "string" ? [one] : typeof one?.id === "string" ? [one.id] : [],
  );
}

/**
 * The complete id of a record. The record is given by its id or by the name of the earthquake.
 *
 * @param {string} written
 * @param {GroundRecord[]} records
 */
function whole(written, records) {
  return (
    records.find((one) => one.id === written)?.id ??
    records.find((one) => one.id.startsWith(written))?.id ??
    written
  );
}
