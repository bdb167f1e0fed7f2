/** A new study: its fields and its JSON are two views of one document, and either can be edited. */

import { ask, refusalBox, Refusal, send, faultText, studyPath } from "./api.js";
import { axisField } from "./axis_field.js";
import { checkbox, debounced, el, fill, picker, prose, say, typedObject } from "./dom.js";
import { help } from "./help.js";
import { count, counted, duration, size } from "./numbers.js";
import { PHYSICAL, RATIOS, STANDS_FOR, inRatios, inUnits } from "./quantities.js";
import { SURVEY, surveyFields } from "./survey_fields.js";
import { contactField, excitationField, startField, steadyField } from "./settings_fields.js";
import { OF_PARTICLE, vocabulary } from "./vocabulary.js";

const FIRST_SCENE = "figure-11";

/** @type {import("./main.js").View} */
export async function studyForm(root, { query }) {
  const [{ studies }, { records }] = await Promise.all([vocabulary(), ask("records")]);
  const named = [...studies, SURVEY];
  const cloned = query.get("from") === null ? null : await clone(query);
  const scenes = cloned ? [cloned, ...named] : named;
  const wanted = cloned?.name ?? query.get("scene") ?? FIRST_SCENE;
  const scene = scenes.find((/** @type {any} */ one) => one.name === wanted) ?? scenes[0];
  let study = structuredClone(scene.definition);
  let number = 0;

  const about = el("div", { class: "quiet about" });
  const fields = el("div", { class: "fields" });
  const text = el("textarea", {
    spellcheck: "false",
    rows: 24,
    "aria-label": "The study as JSON",
    oninput: () => typed(),
  });
  const wrong = el("p", { class: "faults", role: "alert" });
  const estimate = el("div", { class: "estimate", role: "status" });
  const elsewhere = el("div", { class: "faults" });
  const submit = el("button", { type: "submit", class: "primary" }, "Run the study");
  const options = /** @type {[string, string][]} */ (
    scenes.map((/** @type {any} */ one) => [one.name, one.name])
  );

  /** @param {string} name */
  function choose(name) {
    const chosen = scenes.find((/** @type {any} */ one) => one.name === name);
    study = structuredClone(chosen.definition);
    fill(
      about,
      chosen.about.map((/** @type {string} */ paragraph) => el("p", {}, prose(paragraph))),
    );
    draw();
    changed();
  }

  /** Draw the fields anew: the document came from elsewhere, or what it holds has changed. */
  function draw() {
    fill(
      fields,
      study.records === undefined
        ? fieldsOf(study, change, redraw)
        : surveyFields(study, change, redraw, records),
    );
  }

  /** @param {string} path @param {any} value */
  function change(path, value) {
    setAt(study, path, value);
    changed();
  }

  /** @param {any} next */
  function redraw(next) {
    study = next;
    const label = labelOf(document.activeElement);
    draw();
    changed();
    // who changes it by keyboard goes on from there, not from the top of the page
    if (label)
      [...fields.querySelectorAll("select, input")]
        .map((one) => /** @type {HTMLInputElement} */ (one))
        .find((one) => labelOf(one) === label)
        ?.focus();
  }

  function changed() {
    text.value = JSON.stringify(study, null, 2);
    wrong.textContent = "";
    submit.disabled = false;
    judge();
  }

  function typed() {
    const document = typedObject(text, wrong, submit);
    if (document === null) return;
    study = document;
    draw();
    judge();
  }

  const judge = debounced(300, async () => {
    // the question before is not given up, which would end the process that computes it
    const mine = ++number;
    try {
      const cost = await send("studies", study, { dry_run: true });
      if (mine !== number) return;
      showFaults([]);
      fill(estimate, estimated(cost));
    } catch (error) {
      if (mine !== number || !(error instanceof Refusal)) return;
      showFaults(error.faults);
      if (error.faults.length)
        fill(estimate, `${counted(error.faults.length, "fault")} to fix before it can run.`);
      else fill(estimate, refusalBox(error));
    }
  });

  /**
   * Put each fault at the field that it names; what has no field here goes above the button.
   *
   * @param {any[]} faults
   */
  function showFaults(faults) {
    // what is wrong with a file stays until another is chosen
    for (const place of root.querySelectorAll(".faults:not(.upload)")) if (place !== wrong) fill(place);
    for (const marked of root.querySelectorAll("[aria-invalid]")) marked.removeAttribute("aria-invalid");
    for (const fault of faults) {
      const field = fieldOf(fields, fault.field);
      for (const input of field?.querySelectorAll("input") ?? []) input.setAttribute("aria-invalid", "true");
      (field?.querySelector(".faults:not(.upload)") ?? elsewhere).append(el("p", {}, faultText(fault)));
    }
  }

  /** @param {Event} event */
  async function run(event) {
    event.preventDefault();
    submit.disabled = true;
    try {
      const record = await send("studies", study);
      say("The study was submitted.");
      location.hash = `#/studies/${record.id}`;
    } catch (error) {
      submit.disabled = false;
      if (error instanceof Refusal && error.faults.length) showFaults(error.faults);
      else fill(elsewhere, refusalBox(error));
    }
  }

  fill(
    root,
    el("div", { class: "row spread" }, el("h1", {}, "New study"), help("tutorial/#2-a-study", "studies")),
    el("div", { class: "row" }, picker("Start from", options, scene.name, choose)),
    about,
    el(
      "form",
      { class: "columns", onsubmit: run, novalidate: true },
      el("div", {}, fields),
      el(
        "div",
        { class: "beside" },
        el("section", { class: "box cost", "aria-label": "What it will cost" }, estimate, elsewhere, submit),
        el(
          "details",
          { open: window.matchMedia("(min-width: 60rem)").matches },
          el("summary", {}, "The study as JSON"),
          el("p", { class: "quiet" }, "Edit it here or in the fields: each follows the other."),
          text,
          wrong,
        ),
      ),
    ),
  );
  choose(scene.name);
  return () => void ++number;
}

/**
 * A study that is there, to be changed and run again: where the address says so over other frequencies.
 *
 * @param {URLSearchParams} query `from` is its id, `frequencies` start, stop and number
 */
async function clone(query) {
  const record = await ask(studyPath(query.get("from") ?? ""));
  const definition = structuredClone(record.definition);
  const [start, stop, num] = (query.get("frequencies") ?? "").split(",").map(Number);
  definition.name = `${record.name || record.id}, ${num >= 2 ? "over a band" : "changed"}`;
  const { physical } = definition;
  if (num >= 2 && physical?.excitation_frequency_hz !== undefined) {
    const hertz = physical.natural_frequency_hz;
    physical.excitation_frequency_hz = { start: start * hertz, stop: stop * hertz, num };
  } else if (num >= 2) definition.axes.frequency_ratio = { start, stop, num };
  const about = [
    `A copy of ${record.name || record.id}. Points that it shares with the original are not computed again.`,
  ];
  return { name: `copy of ${record.name || record.id}`, about, definition };
}

/** What a field is called, with the group that it stands in. @param {Element | null} field */
function labelOf(field) {
  const own =
    field instanceof HTMLInputElement || field instanceof HTMLSelectElement
      ? field.labels?.[0]?.firstChild
      : null;
  const name =
    field?.getAttribute("aria-label") ??
    own?.parentElement?.querySelector("span")?.textContent ??
    own?.parentElement?.textContent;
  return name && `${field?.closest("fieldset")?.querySelector("legend")?.textContent} ${name}`;
}

/**
 * Every field of a study.
 *
 * @param {any} study
 * @param {(path: string, value: any) => void} change
 * @param {(study: any) => void} redraw
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
    if (withUnits && study.physical[unit] !== undefined) {
      return axisField(PHYSICAL[unit], study.physical[unit], (spec) => change(PHYSICAL[unit].field, spec));
    }
    const quantity = RATIOS[ratio];
    const spec = ratio === "damping_ratio" ? study.damping_ratio : axes[ratio];
    return axisField(quantity, spec ?? quantity.usual, (value) => change(quantity.field, value));
  };
  return [
    el(
      "label",
      { class: "field wide", "data-field": "name" },
      el("span", {}, "Name"),
      name,
      el("span", { class: "faults" }),
    ),
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
        axisField(PHYSICAL[unit], study.physical[unit], (spec) => change(PHYSICAL[unit].field, spec)),
      ),
    Object.keys(RATIOS).map(ofRatio),
    el(
      "details",
      { class: "more" },
      el("summary", {}, "Excitation, contact, starts and when a response counts as steady"),
      excitationField(study, redraw),
      contactField(study, change, redraw),
      startField(study, change, redraw),
      steadyField(study, change),
    ),
  ];
}

/** @param {any} study */
function withoutParticle(study) {
  const axes = { ...study.axes };
  for (const name of OF_PARTICLE) delete axes[name];
  const { particle_friction_ratio: _k, gravity_ratio: _g, ...rest } = study;
  const next = { ...rest, particle: false, axes };
  if (next.physical) {
    const {
      clearance_m: _d,
      particle_mass_kg: _m,
      particle_friction_coefficient: _c,
      tilt_deg: _t,
      ...physical
    } = next.physical;
    next.physical = physical;
  }
  return next;
}

/** @param {any} study */
function withParticleAgain(study) {
  const { particle: _particle, ...rest } = study;
  const axes = { ...study.axes };
  for (const name of OF_PARTICLE) axes[name] ??= RATIOS[name].usual;
  const next = { ...rest, axes };
  return study.physical ? inUnits(next) : next;
}

/** @param {any} study @param {string} path @param {any} value */
function setAt(study, path, value) {
  const keys = path.split(".");
  const last = /** @type {string} */ (keys.pop());
  let place = study;
  for (const key of keys) place = place[key] ??= {};
  place[last] = value;
}

/** The field that a fault names, or that holds what it names. @param {Element} fields @param {string} path */
function fieldOf(fields, path) {
  for (let name = path; name; name = name.replace(/(\.|\[)[^.[]*$|^[^.[]+$/, "")) {
    const found = fields.querySelector(`[data-field="${CSS.escape(name)}"]`);
    if (found) return found;
  }
  return null;
}

/** How much of the time kernels take that are compiled first. @param {any} cost */
function compilingPart(cost) {
  return cost.compiling_seconds ? `, ${duration(cost.compiling_seconds)} of it to compile kernels` : "";
}

/** @param {any} cost */
function estimated(cost) {
  return el(
    "dl",
    { class: "facts" },
    el("div", {}, el("dt", {}, "Points"), el("dd", {}, count(cost.points))),
    el(
      "div",
      {},
      el("dt", {}, "Time on one core"),
      el(
        "dd",
        {},
        `about ${duration(cost.seconds)}${compilingPart(cost)}, between ${duration(cost.seconds_low)} ` +
          `and ${duration(cost.seconds_high)}`,
      ),
    ),
    el("div", {}, el("dt", {}, "At most"), el("dd", {}, size(cost.bytes))),
    el("div", {}, el("dt", {}, "Blocks"), el("dd", {}, count(cost.blocks))),
    cost.understood.length > 0 &&
      el("div", {}, el("dt", {}, "Understood as"), el("dd", {}, cost.understood.join(" "))),
  );
}
