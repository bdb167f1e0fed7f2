/** Shows one design: the progress and the best damper so far, or the completed answer with its report. */
/** @import { Answered, Built, Design, DesignAnswer, Known, OfMass, OtherName, Scale } from "./types.js" */
/** @import { View, Worst } from "./types.js" */

import { address, ask, designPath, refusalBox } from "./api.js";
import { againstMass, calledOf, given, isBeaten, isItself, isMean } from "./design_figures.js";
import { overAmplitudes, overBand } from "./design_figures.js";
import { box, capital, details, el, facts, fill, grid, heading, prose, quiet, say } from "./dom.js";
import { help } from "./help.js";
import { count, counted, drawn, short } from "./numbers.js";
import { actions, badge, isActive } from "./progress.js";
import { nameForm } from "./remarks.js";
import { modelSketch } from "./model_sketch.js";
import { WORDS } from "./words.js";

const LOOK_MILLISECONDS = 1500;
/** Other dampers of the answer, with their titles. */
const OTHERS = /** @type {[OtherName, string][]} */ ([
  ["friction_alone", "Friction alone"],
  ["particle_alone", "The particle alone"],
  ["tuned_mass_damper", "Tuned mass damper of the same mass"],
]);
/** Titles of dampers that may be better than the damper found. @type {Record<string, string>} */
const BUILT = { ...Object.fromEntries(OTHERS), tuned_mass_damper: "Tuned mass damper" };
/** @typedef {{worst: Worst}} Judged */
const { damper, cavity, tables } = WORDS.specification;
const quantities = [...damper, ...cavity];

/** @type {View} */
export async function designView(root, { parts }) {
  const view = new DesignView(await ask(designPath(parts[0])));
  const renamed = (/** @type {string} */ name) => view.renamed(name);
  fill(root, view.head, view.body, nameForm(view.design, renamed));
  return () => view.leave();
}

class DesignView {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  timer;
  left = false;
  head = el("div", { class: "head" });
  body = el("div", { class: "left" });

  /** @param {Design} design */
  constructor(design) {
    this.design = design;
    this.draw();
    this.again();
  }

  leave() {
    this.left = true;
    clearTimeout(this.timer);
  }

  draw() {
    this.drawHead();
    this.drawBody();
  }

  drawHead() {
    const { design } = this;
    fill(
      this.head,
      heading(design.name || `(no name) ${design.id}`, help("how-to/design/", "designs")),
      el("div", { class: "row" }, badge(design.state), el("code", {}, design.id), this.buttons()),
      design.message && el("p", { class: "box fault" }, design.message),
    );
  }

  drawBody() {
    const { id, answer } = this.design;
    const parts = answer ? answered({ id, answer }) : underWay(this.design);
    fill(this.body, parts);
  }

  /** @param {string} name */
  renamed(name) {
    this.design.name = name;
    this.drawHead();
  }

  buttons() {
    const { id, answer } = this.design;
    const again = `#/designs/new?from=${encodeURIComponent(id)}`;
    const report = { href: address(`${designPath(id)}/report`).href, target: "_blank", rel: "noopener" };
    return el(
      "span",
      { class: "row" },
      actions("designs", this.design, (changed) => this.steered(changed)),
      el("a", { class: "button small", href: again }, "Change and ask again"),
      answer && el("a", { class: "button small primary", ...report }, "Report"),
    );
  }

  /** @param {Design | null} changed */
  steered(changed) {
    if (changed === null) {
      location.hash = "#/designs";
      return;
    }
    this.design = changed;
    this.draw();
    this.again();
  }

  again() {
    clearTimeout(this.timer);
    if (!this.left && isActive(this.design.state))
      this.timer = setTimeout(() => this.look(), LOOK_MILLISECONDS);
  }

  async look() {
    const before = this.design;
    try {
      const now = await ask(designPath(before.id));
      if (this.left) return;
      this.design = now;
      this.drawBody();
      // a button in the head may have the focus, so the head is drawn again only if the state has changed
      if (now.state !== before.state || now.message !== before.message) this.drawHead();
      if (!isActive(now.state)) say(`${now.name || now.id}: ${now.state}`);
    } catch (error) {
      if (!this.left) fill(this.body, refusalBox(error));
    }
    this.again();
  }
}

/** The progress of a design, and the best damper so far. @param {Design} design */
function underWay(design) {
  const done = design.points + design.points_of_round;
  return [
    el(
      "section",
      { class: "box", "aria-label": "Progress" },
      el("h2", {}, "Progress"),
      // the bar has no value, because a search usually ends long before the budget is spent
      el("progress", { "aria-label": `Points of ${design.name || design.id}` }),
      el("p", {}, `${count(done)} of at most ${counted(design.budget_points, "point")}.`),
      design.stage &&
        el(
          "p",
          {},
          `${capital(design.stage)}: ${design.studies_done} of the ${design.studies.length} studies of ` +
            `round ${design.round} are done.`,
        ),
      !design.stage && el("p", {}, "It is waiting for its turn."),
    ),
    design.known &&
      el(
        "section",
        { class: "box", "aria-label": "The best so far" },
        el("h2", {}, "The best so far"),
        onDrawing(design.known.design, design.known.worst),
        !design.known.feasible && quiet("It does not keep every limit."),
      ),
  ];
}

/** @param {Answered} design */
function answered(design) {
  const { answer } = design;
  const { cases = [], amplitudes = [], masses = [] } = answer;
  const scale = scaleOf(answer);
  return [
    el("div", { class: "explorer" }, recommended(answer), answer.response.value && overBand(design, scale)),
    el("div", { class: "explorer" }, margins(answer), others(answer)),
    cases.length > 0 && underEach(answer, cases),
    amplitudes.length > 1 && overAmplitudes(design.id, amplitudes),
    starts(answer),
    masses.length > 1 && [ofEachMass(answer, masses), againstMass(design.id, masses, scale)],
    el(
      "details",
      { class: "box" },
      el("summary", {}, "The specification as JSON"),
      el("pre", { tabindex: 0 }, JSON.stringify(answer.specification, null, 2)),
    ),
  ];
}

/** The unit of the values in the figures of an answer. @param {DesignAnswer} answer @returns {Scale} */
function scaleOf(answer) {
  const { units } = answer.worst;
  const unit = units === "m" ? "mm" : units === "1" ? `over ${reference(answer.worst)}` : units;
  const atFrequency = tables.at_a_frequency[answer.worst.measure] ?? measure(answer);
  return { metres: units === "m" ? 1000 : 1, unit, measure: measure(answer), atFrequency };
}

/** The values of the damper to build, with sentences and details. @param {DesignAnswer} answer */
function recommended(answer) {
  // an answer stored by an older version has no verdict, only sentences
  const { sentences = [], rows = [], next = "" } = answer.verdict ?? {};
  const probability = answer.limits.length ? answer.probability : null;
  const found = onDrawing(answer.design, answer.worst, probability, undamped(answer));
  const beaten = isBeaten(answer);
  return el(
    "section",
    { class: "box headline", "aria-label": given(answer) ? "The damper as given" : "Recommended damper" },
    el("h2", {}, headline(answer)),
    beaten ? facts((answer.drawing ?? []).map(([name, value]) => [capital(name), value]), "numbers") : found,
    sentences.map((sentence) => el("p", {}, prose(sentence))),
    next && el("p", {}, "Next: ", prose(next)),
    beaten && [el("h3", {}, capital(calledOf(answer))), found],
    details(
      "Details",
      rows.length > 0 &&
        facts(rows.map(([name, value, what]) => [capital(name), what ? `${value} (${what})` : value])),
      el(
        "ul",
        {},
        answer.words.map((sentence) => el("li", {}, prose(sentence))),
      ),
      modelSketch(answer.design.particle_mass_kg !== 0),
    ),
  );
}

/** The worst case without a damper; null for a mean over the band. @param {DesignAnswer} answer */
function undamped({ no_damper: none, worst }) {
  const values = isMean(worst) ? [] : (none?.response?.value ?? []);
  return values.length ? Math.max(...values.map((value) => value ?? 0)) : null;
}

/** @param {DesignAnswer} answer */
function headline(answer) {
  if (given(answer)) return answer.feasible ? "The damper as given" : "The damper as given exceeds a limit";
  if (isBeaten(answer)) return BUILT[answer.verdict?.damper ?? ""] ?? "No damper is needed";
  return answer.feasible ? "Recommended damper" : "No damper keeps every limit";
}

/** @param {DesignAnswer} answer @param {NonNullable<DesignAnswer["cases"]>} cases */
function underEach(answer, cases) {
  const rows = cases.map((each) => [
    each.record_name ?? each.record,
    String(each.scale),
    response({ ...judged(answer), value: each.value }),
  ]);
  return table("Under each record, as drawn", ["Record", "Scale", capital(measure(answer))], rows);
}

/**
 * A list of a damper's values in the units of a drawing, followed by the damper's worst case.
 *
 * @param {Built} built
 * @param {Worst} worst
 * @param {number | null} [probability]
 * @param {number | null} [without] the worst case without a damper
 */
function onDrawing(built, worst, probability = null, without = null) {
  const rows = quantities
    .filter(({ name }) => quantity(built, name) !== "")
    .map(({ name, called }) => [called, quantity(built, name)]);
  rows.push([isMean(worst) ? measure({ worst }) : `worst ${measure({ worst })}`, response(worst)]);
  if (without !== null) rows.push(["without a damper", response({ ...judged({ worst }), value: without })]);
  if (probability !== null) rows.push(["probability of keeping the limits", short(probability, 3)]);
  return facts(
    rows.map(([label, value]) => [capital(label), value]),
    "numbers",
  );
}

/**
 * A quantity of a damper as text, with its unit or as a ratio; empty if the damper lacks the quantity.
 *
 * @param {Built} built
 * @param {string} name
 */
function quantity(built, name) {
  const of = quantities.find((each) => each.name === name);
  if (!of) return "";
  const value = built[name] ?? null;
  if (value !== null) return `${short(value * of.scale, 4)} ${of.unit}`.trim();
  const ratio = built[of.ratio] ?? null;
  return ratio === null ? "" : `${of.ratio.replaceAll("_", " ")} ${short(ratio, 4)}`;
}

/** The divisor of a response that is given as a ratio, in words. @param {Worst} worst */
function reference(worst) {
  return tables.accelerations.includes(worst.measure)
    ? "the base amplitude times ω_n²"
    : "the base amplitude";
}

/** The values of a damper in one line of text. @param {Built} built */
export function spelledDamper(built) {
  const parts = quantities.map(({ name, called }) => [called, quantity(built, name)]);
  return parts
    .filter(([, value]) => value !== "")
    .map(([label, value]) => `${label} ${value}`)
    .join(", ");
}

/** The worst case of the best damper so far, for a list. @param {Known} known */
export function spelledWorst({ worst, feasible }) {
  const { measure, units, value } = worst;
  return response({ measure, units, value }) + (feasible ? "" : ", exceeds a limit");
}

/** The measure by which an answer judges dampers, and the unit of the measure. @param {Judged} answer */
function judged({ worst: { measure, units } }) {
  return { measure, units };
}

/** @param {Worst} worst */
function response(worst) {
  const value =
    worst.units === "1"
      ? `${short(worst.value, 4)} times ${reference(worst)}`
      : drawn(worst.value, worst.units, 4);
  if (worst.record) return `${value} under ${worst.record_name ?? worst.record} × ${worst.scale}`;
  const at =
    worst.frequency_hz === undefined || worst.frequency_hz === null
      ? worst.frequency_ratio && `r = ${short(worst.frequency_ratio, 4)}`
      : `${short(worst.frequency_hz, 4)} Hz`;
  return at ? `${value} at ${at}` : value;
}

/** @param {Judged} answer */
function measure(answer) {
  return { ...tables.measures, ...tables.measures_under_records }[answer.worst.measure] ?? "response";
}

/** @param {DesignAnswer} answer */
function margins(answer) {
  const spelled = (/** @type {string} */ name, /** @type {number | null} */ value) => {
    if (value === null) return "–";
    const plain = answer.worst.units === "1" && name !== "restitution";
    return plain ? short(value, 4) : quantity({ [name]: value }, name);
  };
  const rows = quantities.filter(({ name }) => answer.margins[name]);
  if (!rows.length) return null;
  return table(
    "How far each quantity may change alone",
    ["Quantity", "From", "To", "Fails at"],
    rows.map(({ name, label }) => {
      const one = answer.margins[name];
      const fails = [one.fails_below, one.fails_above]
        .filter((each) => each !== null)
        .map((each) => spelled(name, each));
      return [capital(label), spelled(name, one.low), spelled(name, one.high), fails.join(", ") || "–"];
    }),
  );
}

/** @param {DesignAnswer} answer */
function others(answer) {
  const rows = [[capital(calledOf(answer)), response(answer.compared ?? answer.worst), "1"]];
  for (const [name, title] of OTHERS) {
    const one = answer[name];
    if (one && !isItself(answer, name))
      rows.push([
        title + (one.feasible === false ? ", exceeds a limit" : ""),
        response(one.worst),
        short(one.ratio, 3),
      ]);
    if (one?.detuned)
      rows.push([
        `${title}, up to ${100 * (one.detuned_by ?? 0)} % out of tune`,
        response(one.detuned),
        one.ratio && one.worst.value ? short((one.ratio * one.detuned.value) / one.worst.value, 3) : "",
      ]);
  }
  return table("Beside other dampers", ["Damper", "Worst case", "Ratio"], rows);
}

/** A table of the frequencies at which several responses are possible. @param {DesignAnswer} answer */
function starts({ starts: known, worst }) {
  if (!known?.where.length) return null;
  const rows = known.where.flatMap((at) =>
    at.responses.map((each, i) => [
      i
        ? ""
        : at.frequency_hz === null
          ? `r = ${short(at.frequency_ratio, 4)}`
          : `${short(at.frequency_hz, 4)} Hz`,
      response({
        measure: "worst_displacement",
        units: worst.units === "1" ? "1" : "m",
        value: each.displacement,
      }),
      `${Math.round(each.share * known.count)} of ${known.count}`,
      (each.response_class ?? "–").replaceAll("_", " ") + (each.from_rest ? ", from rest" : ""),
    ]),
  );
  return el(
    "details",
    { class: "box" },
    el(
      "summary",
      {},
      `More than one response, at ${known.several} of ${counted(known.frequencies, "frequency ratio")}`,
    ),
    grid("More than one response", ["Near", "Displacement", "Starts", "Class"], rows),
  );
}

/**
 * A table of the best damper for each mass of the particle, with the response.
 *
 * @param {DesignAnswer} answer
 * @param {OfMass[]} masses
 */
function ofEachMass(answer, masses) {
  const of = (/** @type {number | null} */ value) =>
    value === null ? "–" : response({ ...judged(answer), value });
  const rows = masses.map((each) => [
    quantity(massOf(each), "particle_mass_kg") + (each.recommended ? `, ${calledOf(answer)}` : ""),
    of(each.worst.value) + (each.feasible ? "" : ", exceeds a limit"),
    of(each.tuned_mass_damper),
    of(each.particle_alone),
    quantity(each.design, "clearance_m") || "–",
    quantity(each.design, "friction_force_n"),
    count(each.looked_at),
  ]);
  return table(
    "Response over mass: for each mass the best damper examined, as drawn",
    ["Particle", "Best found", "Tuned mass damper", "Particle alone", "Clearance", "Friction", "Looked at"],
    rows,
  );
}

/** @param {OfMass} each @returns {Built} */
function massOf({ particle_mass_kg, mass_ratio }) {
  return { particle_mass_kg: particle_mass_kg ?? null, mass_ratio: mass_ratio ?? null };
}

/** @param {string} title @param {string[]} columns @param {string[][]} rows */
function table(title, columns, rows) {
  return box(title, grid(title, columns, rows));
}
