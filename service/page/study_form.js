/** The form of a new study: its fields, and the expected cost. */
/** @import { Child, Definition, Estimate, View } from "./types.js" */

import { ask, studyPath } from "./api.js";
import { axisField } from "./axis_field.js";
import { field } from "./faults.js";
import { documentForm } from "./document_form.js";
import { checkbox, el, facts, picker, prose, say } from "./dom.js";
import { help } from "./help.js";
import { count, duration, size } from "./numbers.js";
import { PHYSICAL, RATIOS, STANDS_FOR, inRatios, inUnits } from "./quantities.js";
import { SURVEY, surveyFields } from "./survey_fields.js";
import { cavityFields, contactField, excitationField, startField, steadyField } from "./settings_fields.js";
import { OF_PARTICLE, vocabulary } from "./vocabulary.js";
import { WORDS } from "./words.js";

const FIRST_SCENE = "figure-11";

/** @type {View} */
export async function studyForm(root, { query }) {
  const [{ studies }, { records }] = await Promise.all([vocabulary(), ask("records")]);
  const copied = query.get("from") === null ? [] : [await copy(query)];
  return documentForm(root, {
    title: "New study",
    help: help("tutorial/#2-a-study", "studies"),
    json: "The study as JSON",
    path: "studies",
    submit: "Run the study",
    cost: "Expected cost",
    can: "run",
    starts: [...copied, ...studies, SURVEY],
    first: copied[0]?.name ?? query.get("scene") ?? FIRST_SCENE,
    fields: ({ document, set, put }) => {
      const study = /** @type {Definition} */ (document);
      return study.records === undefined ? fieldsOf(study, set, put) : surveyFields(study, set, put, records);
    },
    estimated,
    done: ({ id }) => {
      say("The study was submitted.");
      location.hash = `#/studies/${id}`;
    },
  });
}

/**
 * A copy of an existing study, with which the form begins. The address may give other frequencies.
 *
 * @param {URLSearchParams} query `from` is the id of the study; `frequencies` gives start, stop and number
 */
async function copy(query) {
  const record = await ask(studyPath(query.get("from") ?? ""));
  const definition = structuredClone(record.definition);
  const [start, stop, num] = (query.get("frequencies") ?? "").split(",").map(Number);
  definition.name = `${record.name || record.id}, ${num >= 2 ? "over a band" : "changed"}`;
  const { physical } = definition;
  if (num >= 2 && physical?.excitation_frequency_hz !== undefined) {
    const hertz = Number(physical.natural_frequency_hz);
    physical.excitation_frequency_hz = { start: start * hertz, stop: stop * hertz, num };
  } else if (num >= 2) definition.axes.frequency_ratio = { start, stop, num };
  const about = [
    `A copy of ${record.name || record.id}. Points that it shares with the original are not computed again.`,
  ];
  return { name: `copy of ${record.name || record.id}`, about, definition };
}

/**
 * Every field of a study.
 *
 * @param {Definition} study
 * @param {(path: string, value: unknown) => void} change
 * @param {(study: Definition) => void} redraw
 */
function fieldsOf(study, change, redraw) {
  const axes = study.axes ?? {};
  const withParticle = study.particle !== false;
  const withUnits = study.physical !== undefined && study.physical !== null;
  const name = el("input", {
    type: "text",
    maxlength: 200,
    value: study.name ?? "",
    oninput: () => change("name", name.value),
  });
  /** @param {string} ratio */
  const ofRatio = (ratio) => {
    if (!withParticle && OF_PARTICLE.includes(ratio)) return null;
    const unit = STANDS_FOR[ratio];
    const physical = study.physical?.[unit];
    if (physical !== undefined)
      return axisField(PHYSICAL[unit], physical, (spec) => change(PHYSICAL[unit].field, spec));
    const quantity = RATIOS[ratio];
    const spec = ratio === "damping_ratio" ? study.damping_ratio : axes[ratio];
    return axisField(quantity, spec ?? quantity.usual, (value) => change(quantity.field, value));
  };
  return [
    field("name", "Name", name, { wide: true }),
    el(
      "div",
      { class: "row" },
      checkbox("With a particle", withParticle, (on) =>
        redraw(on ? withParticleAgain(study) : withoutParticle(study)),
      ),
      picker(
        "Sizes as",
        [
          ["ratios", "ratios"],
          ["units", "units: mm, N, Hz, kg"],
        ],
        withUnits ? "units" : "ratios",
        (kind) => redraw(kind === "units" ? inUnits(study) : inRatios(study)),
      ),
    ),
    withUnits &&
      ["mass_kg", "natural_frequency_hz", "base_amplitude_m"].map((unit) =>
        axisField(PHYSICAL[unit], study.physical?.[unit], (spec) => change(PHYSICAL[unit].field, spec)),
      ),
    Object.keys(RATIOS).map(ofRatio),
    el(
      "details",
      { class: "more" },
      el("summary", {}, "Cavity, excitation, contact, starts and when a response counts as steady"),
      withParticle && cavityFields(study, change),
      excitationField(study, redraw),
      contactField(study, change, redraw),
      startField(study, change, redraw),
      steadyField(study, change),
    ),
  ];
}

/** @param {Definition} study */
function withoutParticle(study) {
  /** @type {Definition} */
  const next = { ...study, particle: false, axes: { ...study.axes } };
  if (study.physical) next.physical = { ...study.physical };
  for (const name of [...OF_PARTICLE, ...Object.keys(WORDS.before)]) {
    delete next[name];
    delete next.axes[name];
    delete next.physical?.[WORDS.stands_for[name]];
  }
  return next;
}

/** @param {Definition} study */
function withParticleAgain(study) {
  const { particle: _particle, ...rest } = study;
  const axes = { ...study.axes };
  for (const name of OF_PARTICLE) axes[name] ??= RATIOS[name].usual;
  const next = { ...rest, axes };
  return study.physical ? inUnits(next) : next;
}

/** A phrase about the time that compiling kernels takes. @param {Estimate} cost */
function compilingPart(cost) {
  return cost.compiling_seconds ? `, ${duration(cost.compiling_seconds)} of it to compile kernels` : "";
}

/** @param {Estimate} cost */
function estimated(cost) {
  const time =
    `about ${duration(cost.seconds)}${compilingPart(cost)}, between ${duration(cost.seconds_low)} ` +
    `and ${duration(cost.seconds_high)}`;
  const understood = cost.understood.join(" ");
  return facts([
    ["Points", count(cost.points)],
    ["Time on one core", time],
    ["At most", size(cost.bytes)],
    ["Blocks", count(cost.blocks)],
    .../** @type {[string, Child][]} */ (understood ? [["Understood as", prose(understood)]] : []),
  ]);
}
