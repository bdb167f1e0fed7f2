/**
 * A new design: the fields of a specification and its JSON are two views of one document, and either can be
 * edited.
 */

import { ask, faultText, Refusal, refusalBox, send } from "./api.js";
import { debounced, el, fill, picker, prose, say, typedObject } from "./dom.js";
import { excitationFields, measuresOf, shakenBy } from "./excitation_fields.js";
import { help } from "./help.js";
import { modelSketch } from "./model_sketch.js";
import { count, counted, short } from "./numbers.js";
import { group, number, read, shown, span, titled } from "./specified.js";
import { vocabulary } from "./vocabulary.js";
import { WORDS } from "./words.js";

/** @typedef {import("./words.js").SpecifiedField} SpecifiedField */
/** @typedef {import("./specified.js").Held} Held */

const { structure, damper, ratios, limits, numbers, contact_time: contactTime } = WORDS.specification;
const FIRST = "prototype";
/** How a quantity of the damper is said. */
const WAYS = /** @type {[string, string][]} */ ([
  ["given", "given"],
  ["range", "in a range"],
  ["list", "from a list"],
]);

/** @type {import("./main.js").View} */
export async function designForm(root, { query }) {
  const [{ specifications }, { records }] = await Promise.all([vocabulary(), ask("records")]);
  const from = query.get("from");
  const named = from === null ? specifications : [await copy(from), ...specifications];
  let asked = /** @type {any} */ ({});
  let number = 0;

  const about = el("div", { class: "quiet about" });
  const fields = el("div", { class: "fields" });
  const text = el("textarea", {
    spellcheck: "false",
    rows: 24,
    "aria-label": "The specification as JSON",
    oninput: () => typed(),
  });
  const wrong = el("p", { class: "faults", role: "alert" });
  const budget = el("div", { class: "estimate", role: "status" });
  const elsewhere = el("div", { class: "faults" });
  const submit = el("button", { type: "submit", class: "primary" }, "Find the damper");

  /** @param {string} name */
  function choose(name) {
    const chosen = named.find((/** @type {any} */ one) => one.name === name);
    asked = structuredClone(chosen.definition);
    fill(
      about,
      chosen.about.map((/** @type {string} */ paragraph) => el("p", {}, prose(paragraph))),
    );
    draw();
    changed();
  }

  function draw() {
    fill(
      fields,
      ...fieldsOf({ get: (path) => at(asked, path), set, again: () => (draw(), changed()) }, records),
    );
  }

  /** @param {string} path @param {any} value undefined takes it away */
  function set(path, value) {
    put(asked, path.split("."), value);
    changed();
  }

  function changed() {
    text.value = JSON.stringify(asked, null, 2);
    wrong.textContent = "";
    submit.disabled = false;
    judge();
  }

  function typed() {
    const document = typedObject(text, wrong, submit);
    if (document === null) return;
    asked = document;
    draw();
    judge();
  }

  const judge = debounced(300, async () => {
    // the question before is not given up, which would end the process that computes it
    const mine = ++number;
    try {
      const found = await send("designs", asked, { dry_run: true });
      if (mine !== number) return;
      showFaults([]);
      fill(
        budget,
        "To be chosen: " +
          `${found.chosen.map(labelOf).join("; ")}. ` +
          "" +
          `At most ${count(found.budget_points)} points. ${found.understood.join(" ")}`,
      );
    } catch (error) {
      if (mine !== number || !(error instanceof Refusal)) return;
      showFaults(error.faults);
      fill(
        budget,
        error.faults.length
          ? `${counted(error.faults.length, "fault")} to fix before it can be searched.`
          : refusalBox(error),
      );
    }
  });

  /**
   * Put each fault at the field that it names; what has no field here goes above the button.
   *
   * @param {any[]} faults
   */
  function showFaults(faults) {
    for (const place of root.querySelectorAll(".faults")) if (place !== wrong) fill(place);
    for (const marked of root.querySelectorAll("[aria-invalid]")) marked.removeAttribute("aria-invalid");
    for (const fault of faults) {
      const field = fieldOf(fields, fault.field);
      for (const input of field?.querySelectorAll("input") ?? []) input.setAttribute("aria-invalid", "true");
      (field?.querySelector(".faults") ?? elsewhere).append(el("p", {}, faultText(fault)));
    }
  }

  /** @param {Event} event */
  async function run(event) {
    event.preventDefault();
    submit.disabled = true;
    try {
      const design = await send("designs", asked);
      say("The design was asked for.");
      location.hash = `#/designs/${design.id}`;
    } catch (error) {
      submit.disabled = false;
      if (error instanceof Refusal && error.faults.length) showFaults(error.faults);
      else fill(elsewhere, refusalBox(error));
    }
  }

  const options = named.map((/** @type {any} */ one) => [one.name, one.name]);
  const first = from === null ? (query.get("specification") ?? FIRST) : named[0].name;
  const start = named.some((/** @type {any} */ one) => one.name === first) ? first : named[0].name;
  fill(
    root,
    el(
      "div",
      { class: "row spread" },
      el("h1", {}, "New design"),
      help("how-to/design/#what-a-specification-holds", "specifications"),
    ),
    el("div", { class: "row" }, picker("Start from", options, start, choose)),
    about,
    el(
      "form",
      { class: "columns", onsubmit: run, novalidate: true },
      el("div", {}, fields),
      el(
        "div",
        { class: "beside" },
        el("section", { class: "box", "aria-label": "The model" }, modelSketch()),
        el("section", { class: "box cost", "aria-label": "What it may take" }, budget, elsewhere, submit),
        el(
          "details",
          { open: window.matchMedia("(min-width: 60rem)").matches },
          el("summary", {}, "The specification as JSON"),
          el("p", { class: "quiet" }, "Edit it here or in the fields: each follows the other."),
          text,
          wrong,
        ),
      ),
    ),
  );
  choose(start);
  return () => void ++number;
}

/** The specification of a design that is there, to be changed. @param {string} id */
async function copy(id) {
  const design = await ask(`designs/${encodeURIComponent(id)}`);
  const name = design.name || design.id;
  return {
    name: `copy of ${name}`,
    about: [`A copy of ${name}. Points that it shares with the original are not computed again.`],
    definition: { ...design.specification, name: `${name}, changed` },
  };
}

/** What a quantity of the damper is called. @param {string} name */
function labelOf(name) {
  return damper.find((each) => each.name === name)?.label ?? name;
}

/**
 * Every field of a specification.
 *
 * @param {Held} held
 * @param {any[]} records ground-motion records that the service has
 */
function fieldsOf(held, records) {
  const measures = measuresOf(held);
  // what a document holds is shown even where it cannot hold
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
    el(
      "label",
      { class: "field wide", "data-field": "name" },
      el("span", {}, "Name"),
      name,
      el("span", { class: "faults" }),
    ),
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
 * A quantity of the damper: given, or what it may be; and its tolerance.
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
  const chosen = held.get(place);
  const way = chosen === undefined ? "given" : Array.isArray(chosen) ? "list" : "range";
  const change = (/** @type {string} */ next) => {
    const last = held.get(place);
    const values =
      last === undefined
        ? [held.get(each.name) ?? 0]
        : Array.isArray(last)
          ? last.map(valueOf(each))
          : typeof last === "object"
            ? [last.start, last.stop]
            : [last];
    const [low, high] = [Math.min(...values), Math.max(...values)];
    held.set(each.name, next === "given" ? low : undefined);
    held.set(
      place,
      next === "range"
        ? { start: low, stop: high > low ? high : low + (low || 1) }
        : next === "list"
          ? [low, high > low ? high : low + (low || 1)]
          : undefined,
    );
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
 * Values, each with a name where it has one.
 *
 * @param {Held} held
 * @param {string} path
 * @param {SpecifiedField} each
 */
function list(held, path, each) {
  const time = contactTime.name;
  const one = (/** @type {any} */ value) => {
    if (typeof value !== "object") return shown(value, each);
    const ms = value[time] ? ` (${short(1e3 * value[time], 4)} ms)` : "";
    return `${value.name ?? ""} ${shown(value[each.name], each)}${ms}`.trim();
  };
  const box = el("input", {
    type: "text",
    value: held.get(path).map(one).join(", "),
    oninput: () => held.set(path, box.value.split(",").map(entry)),
  });
  /** @param {string} part */
  function entry(part) {
    const [, name, value, ms] = /^\s*(.*?)\s*([^\s(]*)\s*(?:\(\s*(\S+)\s*ms\s*\))?\s*$/.exec(part) ?? [];
    const found = read(value, each) ?? null;
    return name || ms
      ? { ...(name ? { name } : {}), [each.name]: found, ...(ms ? { [time]: Number(ms) / 1e3 } : {}) }
      : found;
  }
  const told =
    each.name === "restitution"
      ? "Values, with names as in rubber 0.3, steel 0.8; with a contact time as in rubber 0.3 (4 ms)"
      : "Values, with names as in light 1.2, heavy 2.5";
  return el(
    "label",
    { class: "field", "data-field": path },
    el("span", {}, told),
    box,
    el("span", { class: "faults" }),
  );
}

/** @param {SpecifiedField} each @returns {(one: any) => number} */
function valueOf(each) {
  return (one) => Number(typeof one === "object" ? one[each.name] : one);
}

/** How far it may be off: in the unit, or as a share. @param {Held} held @param {SpecifiedField} each */
function tolerance(held, each) {
  const path = `tolerances.${each.name}`;
  const value = held.get(path);
  const box = el("input", {
    type: "text",
    value: typeof value === "string" ? value : shown(value, each),
    placeholder: "exact",
    oninput: () => held.set(path, box.value.includes("%") ? box.value.trim() : read(box.value, each)),
  });
  return el(
    "label",
    { class: "field", "data-field": path },
    el("span", {}, `± ${each.unit ? `${each.unit}, or a share` : "the number, or a share"} as 10%`),
    box,
    el("span", { class: "faults" }),
  );
}

/** @param {any} document @param {string} path */
function at(document, path) {
  return path
    .split(".")
    .reduce((held, key) => (held !== null && typeof held === "object" ? held[key] : undefined), document);
}

/**
 * Put a value at a path; undefined takes it away, with what is empty then.
 *
 * @param {any} held
 * @param {string[]} way
 * @param {any} value
 */
function put(held, [key, ...rest], value) {
  if (!rest.length) {
    if (value === undefined) delete held[key];
    else held[key] = value;
    return;
  }
  if (held[key] === null || typeof held[key] !== "object") {
    if (value === undefined) return;
    held[key] = {};
  }
  put(held[key], rest, value);
  if (key !== "choose" && !Array.isArray(held) && Object.keys(held[key]).length === 0) delete held[key];
}

/**
 * The element of a field: that of its longest beginning.
 *
 * @param {Element} fields
 * @param {string} name
 * @returns {Element | null}
 */
function fieldOf(fields, name) {
  for (
    let path = name.replaceAll("[", ".").replaceAll("]", "");
    path;
    path = path.includes(".") ? path.slice(0, path.lastIndexOf(".")) : ""
  ) {
    const found = fields.querySelector(`[data-field="${CSS.escape(path)}"]`);
    if (found) return found;
  }
  return fields.querySelector(`[data-field="${CSS.escape(name.replace(/^(choose|tolerances)\./, ""))}"]`);
}
