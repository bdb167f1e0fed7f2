/** Estimates parameters of a prototype from a measured table and known values. */
/** @import { Fitted, FittedField, Held, View } from "./types.js" */

import { documentForm } from "./document_form.js";
import { checkbox, details, el, fill, grid, picker, prose } from "./dom.js";
import { field } from "./faults.js";
import { CURVES, Figure } from "./figure.js";
import { help } from "./help.js";
import { short } from "./numbers.js";
import { compiling } from "./patience.js";
import { group, number, read, shown, titled } from "./specified.js";
import { WORDS } from "./words.js";

const QUANTITIES = WORDS.fitted;
const SHARE = { name: "deviation", label: "deviation of each amplitude, as a share", unit: "", scale: 1 };
const TABLE = "frequency (Hz), amplitude (mm)\n2.3, 6.1\n2.4, 10.2\n2.5, 16.4\n2.6, 11.8\n2.7, 7.6\n";
const STARTS = [
  {
    name: "your own measurement",
    about: [
      "Amplitudes over frequency, or one time history; known values of the machine, and what to estimate.",
    ],
    definition: { measured: "", structure: {}, fit: {} },
    empty: true,
  },
  {
    name: "friction of a structure",
    about: ["Five amplitudes of a structure that is shaken by 1 mm; its friction is estimated."],
    definition: {
      measured: TABLE,
      structure: {
        particle: false,
        damping_ratio: 0.02,
        physical: { natural_frequency_hz: 2.5, base_amplitude_m: 0.001 },
      },
      fit: { friction_ratio: [0, 0.7] },
      deviation: 0.05,
    },
  },
];

/** @type {View} */
export async function fitView(root, { query }) {
  const answer = el("div", { class: "left", role: "status" });
  const form = el("div", { class: "view" });
  fill(root, form, answer);
  return documentForm(form, {
    title: "Fit",
    help: help("how-to/fit/", "fits"),
    json: "The question as JSON",
    path: "fits",
    submit: "Estimate",
    cost: "Expected time",
    can: "be estimated",
    starts: STARTS,
    first: query.get("example") ?? STARTS[0].name,
    fields: fieldsOf,
    estimated: (ready) =>
      ready.phase === "compiling" ? compiling(ready) : "The estimate takes seconds to minutes.",
    waits: () => fill(answer, el("p", { class: "box" }, "Estimating …")),
    done: (found) => answered(answer, found),
  });
}

/** @param {Held} held */
function fieldsOf(held) {
  const sought = QUANTITIES.filter(
    ({ usual, path, name }) => usual || said(held, path) || said(held, `fit.${name}`),
  );
  return [
    measuredField(held),
    checkbox("With a particle", held.get("structure.particle") !== false, (on) => {
      held.set("structure.particle", on ? undefined : false);
      held.again();
    }),
    ...sought.map((each) => quantityField(held, each)),
    group("Uncertainty of the measurement", "deviation", [number(held, "deviation", SHARE)]),
  ];
}

/** @param {Held} held @param {string} path */
function said(held, path) {
  return held.get(path) !== undefined;
}

/** The field for the measured table, which is typed or read from a file. @param {Held} held */
function measuredField(held) {
  const text = el("textarea", {
    rows: 8,
    spellcheck: "false",
    value: held.get("measured") ?? "",
    "aria-label": "Table of measured values",
    oninput: () => held.set("measured", text.value),
  });
  const file = el("input", {
    type: "file",
    accept: ".csv,.txt,text/plain,text/csv",
    "aria-label": "File of measured values",
    onchange: async () => {
      const chosen = file.files?.[0];
      if (chosen) held.set("measured", (text.value = await chosen.text()));
    },
  });
  const title = "Measured values: a first line with names and units, then one row for each frequency";
  return field("measured", title, [text, file], { wide: true });
}

/** The fields of a quantity, which may be given or estimated. @param {Held} held @param {FittedField} each */
function quantityField(held, each) {
  const place = `structure.${each.path}`;
  const range = `fit.${each.name}`;
  const way = said(held, range) ? "sought" : said(held, place) ? "known" : "";
  const ways = [
    ["", "not given"],
    ["known", "known"],
    ["sought", "sought"],
  ];
  const change = (/** @type {string} */ next) => {
    held.set(place, next === "known" ? null : undefined);
    held.set(range, next === "sought" ? null : undefined);
    held.again();
  };
  return group(titled(each), place, [
    picker("It is", /** @type {[string, string][]} */ (ways.slice(0, each.free ? 3 : 2)), way, change),
    way === "known" && number(held, place, each, "Value"),
    way === "sought" && rangeField(held, range, each),
  ]);
}

/**
 * The fields of the range in which a parameter is estimated. Two empty fields mean the default range.
 *
 * @param {Held} held
 * @param {string} path
 * @param {FittedField} each
 */
function rangeField(held, path, each) {
  const [low, high] = held.get(path) ?? [];
  const end = (/** @type {string} */ label, /** @type {number | undefined} */ value) =>
    el("input", {
      type: "number",
      step: "any",
      value: shown(value, each),
      "aria-label": `${titled(each)}, ${label}`,
      oninput: () => {
        const [one, other] = [read(from.value, each), read(to.value, each)];
        held.set(path, one === undefined && other === undefined ? null : [one ?? null, other ?? null]);
      },
    });
  const [from, to] = [end("from", low), end("to", high)];
  return field(path, "From and to", [el("span", { class: "ends" }, from, "to", to)], each);
}

/** @param {HTMLElement} place @param {Fitted} found */
function answered(place, found) {
  const named = (/** @type {string} */ name) => QUANTITIES.find((each) => each.name === name);
  const rows = Object.entries(found.parameters).map(([name, { value, low, high, determined }]) => {
    const each = named(name);
    const digits = digitsOf(low, high);
    const text = (/** @type {number} */ number) => short(number * (each?.scale ?? 1), digits);
    return [
      each ? titled(each) : name,
      text(value),
      `${text(low)} to ${text(high)}`,
      determined ? "yes" : "no",
    ];
  });
  const heads = [
    "Parameter",
    "Value",
    `Interval of ${short(100 * found.confidence)} %`,
    "Determined by the data?",
  ];
  const chart = new Figure({ label: "Measurement and fitted model", name: "fit", height: 380 });
  fill(
    place,
    el(
      "div",
      { class: "explorer" },
      el(
        "section",
        { class: "box headline", "aria-label": "What was found" },
        el("h2", {}, "What was found"),
        grid("What was found", heads, rows),
        found.words.map((sentence) => el("p", {}, prose(sentence))),
        json("The prototype as a study, in JSON", found.study),
      ),
      chart.element,
    ),
  );
  place.scrollIntoView({ block: "nearest" });
  return chart.draw(
    () => tracesOf(found),
    () => titlesOf(found),
  );
}

/**
 * Number of significant digits for a value with an interval; at least 4. Half the width of the interval has
 * two digits if it is rounded to the same decimal place as the value.
 *
 * @param {number} low
 * @param {number} high
 */
function digitsOf(low, high) {
  const half = (high - low) / 2;
  const largest = Math.max(Math.abs(low), Math.abs(high));
  if (!(half > 0 && half < largest)) return 4;
  return Math.max(4, Math.floor(Math.log10(largest)) - Math.floor(Math.log10(half)) + 2);
}

/** @param {string} title @param {object | null} document */
function json(title, document) {
  return document && details(title, el("pre", { tabindex: 0 }, JSON.stringify(document, null, 2)));
}

/** Measured and fitted curves over frequency or time, with lengths in millimetres. @param {Fitted} found */
function tracesOf({ rows, units, time_s, measured_m, model_m }) {
  const by = rows && units.amplitude !== "m" ? 1 : 1000;
  const column = (/** @type {"measured" | "model"} */ name, /** @type {number[]} */ overTime) =>
    (rows?.map((row) => row[name]) ?? overTime).map((value) => value * by);
  const x = rows?.map((row) => row.frequency) ?? time_s;
  const [first, second] = CURVES();
  const mode = rows ? "markers" : "lines";
  return [
    {
      x,
      y: column("measured", measured_m),
      name: "measured",
      mode,
      marker: { color: first, size: 9 },
      line: { color: first },
    },
    {
      x,
      y: column("model", model_m),
      name: "model",
      mode,
      marker: { color: second, size: 9, symbol: "x" },
      line: { color: second, dash: "dash" },
    },
  ];
}

/** @param {Fitted} found */
function titlesOf({ rows, units }) {
  const amplitude = rows && units.amplitude !== "m" ? "amplitude ratio X/Z" : "amplitude [mm]";
  const across = !rows ? "time [s]" : units.frequency === "Hz" ? "frequency [Hz]" : "frequency ratio r";
  return {
    xaxis: { title: across },
    yaxis: { title: rows ? amplitude : "displacement [mm]" },
  };
}
