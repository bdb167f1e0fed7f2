/** The study's damper beside a tuned mass damper, with the controls that put the latter out of tune. */
/** @import { Comparison, Shown, Tab } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, el, fill, picker, prose } from "./dom.js";
import { CURVES, DASHES, figure } from "./figure.js";
import { judgedOver } from "./headline.js";
import { help } from "./help.js";
import { short } from "./numbers.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { sliders } from "./sliders.js";
import { TUNINGS } from "./vocabulary.js";

const FARTHEST = 0.5;
const USUAL = "minimax";

/** @type {Tab} */
export function comparisonTab(session, place) {
  const { selection, record } = session;
  const { kept } = session;
  const asked = {
    criterion: kept.one("criterion", Object.keys(session.words.tunings), USUAL),
    detuning: kept.number("detuning", -FARTHEST, FARTHEST, 0),
    damping_detuning: kept.number("damping_detuning", -FARTHEST, FARTHEST, 0),
    /** @type {number | null} */ mass_ratio: kept.number("tmd_mass_ratio", 0, Infinity, 0) || null,
  };
  const answerBox = el("div", { class: "ratio", role: "status" });
  const note = el("p", { class: "quiet note" });
  const chart = figure({
    label: "Frequency responses: the study's damper, a tuned mass damper, no damper",
    name: `tmd-${record.id}`,
    height: 420,
    python: () => pythonLine(record.id, "tmd_comparison", question()),
  });
  let number = 0;

  function question() {
    const at = selection.at([FREQUENCY]);
    const { mass_ratio, ...tuning } = asked;
    return { ...at, ...tuning, tmd_mass_ratio: mass_ratio };
  }

  /** @param {Partial<typeof asked>} what */
  function change(what) {
    Object.assign(asked, what);
    // at once: a moment later another tab may have the address
    kept.keep({
      criterion: asked.criterion === USUAL ? null : asked.criterion,
      detuning: asked.detuning || null,
      damping_detuning: asked.damping_detuning || null,
      tmd_mass_ratio: asked.mass_ratio,
    });
    look();
  }

  const look = debounced(150, async () => {
    const mine = ++number;
    try {
      const answer = await ask(studyPath(record.id, "tmd-comparison"), question());
      if (mine !== number) return;
      fill(
        answerBox,
        verdict(answer, session.shown),
        el("p", {}, judgedOver(record.id, session.shown, answer.next_frequencies)),
      );
      fill(note, prose(session.shown.words(answer).note));
      meaning.textContent = answer.criterion_means;
      await chart.draw(
        () => traces(answer, session.shown),
        () => ({
          xaxis: {
            title: {
              text: session.shown.has(FREQUENCY) ? session.shown.title(FREQUENCY) : "frequency ratio r",
            },
          },
          yaxis: {
            title: { text: session.shown.variable("amplitude_ratio", "amplitude ratio X/Z") },
            type: "log",
            dtick: "D2",
          },
        }),
      );
    } catch (error) {
      if (mine === number) fill(answerBox, refusalBox(error));
    }
  });

  const { shown } = session;
  const by = shown.factor("mass_ratio");
  const mass = el("input", {
    type: "number",
    step: "any",
    min: 0,
    placeholder: "as the design",
    value: asked.mass_ratio === null ? "" : short(asked.mass_ratio * by, 12),
    oninput: () => change({ mass_ratio: mass.value === "" ? null : Number(mass.value) / by }),
  });
  const meaning = el("p", { class: "quiet" });
  fill(
    place,
    el(
      "div",
      { class: "study" },
      el("div", { class: "left" }, answerBox, chart.element, note),
      el(
        "section",
        { class: "box" },
        help("notebooks/tuned-mass-damper/", "comparing with a tuned mass damper"),
        el("h2", {}, "Tuned mass damper"),
        picker("Tuned by", TUNINGS, asked.criterion, (criterion) => change({ criterion })),
        meaning,
        share("Frequency off by", asked.detuning, (detuning) => change({ detuning })),
        share("Damping off by", asked.damping_detuning, (damping_detuning) => change({ damping_detuning })),
        el(
          "label",
          { class: "field" },
          el("span", {}, shown.has("mass_ratio") ? "Mass of the tuned mass damper [kg]" : "Mass ratio μ"),
          mass,
        ),
        sliders(selection, session.shown, true),
      ),
    ),
  );
  selection.addEventListener("chosen", look);
  session.changes.addEventListener("grown", look);
  look();
}

/**
 * A share from −50 to 50 per cent as a slider.
 *
 * @param {string} label
 * @param {number} now
 * @param {(value: number) => void} onChange
 */
function share(label, now, onChange) {
  const percent = Math.round(100 * now);
  const output = el("output", {}, `${percent} %`);
  const slider = el("input", {
    type: "range",
    min: -100 * FARTHEST,
    max: 100 * FARTHEST,
    step: 1,
    "aria-valuetext": `${percent} per cent`,
    oninput: () => {
      output.textContent = `${slider.value} %`;
      slider.setAttribute("aria-valuetext", `${slider.value} per cent`);
      onChange(Number(slider.value) / 100);
    },
  });
  slider.value = String(percent); // after its limits: before them a browser would cut it
  return el("label", { class: "slider" }, el("span", {}, label), slider, output);
}

/**
 * Which is better, in a sentence and a number.
 *
 * @param {Comparison} answer
 * @param {Shown} shown
 */
function verdict(answer, shown) {
  const sentences = shown.words(answer).verdict.map((sentence) => el("p", {}, prose(sentence)));
  // of too few frequencies a ratio would say more than is known
  if (answer.ratio === null || !answer.judged) return sentences;
  return [
    el(
      "p",
      { class: "big" },
      el("strong", { id: "tmd-ratio" }, short(answer.ratio, 4)),
      " hybrid over tuned mass damper",
    ),
    ...sentences,
  ];
}

/** @param {Comparison} answer @param {Shown} shown */
function traces(answer, shown) {
  const curves = /** @type {["hybrid" | "tmd" | "no_damper", string][]} */ ([
    ["hybrid", "this study"],
    ["tmd", "tuned mass damper"],
    ["no_damper", "no damper"],
  ]);
  const mode = answer.frequency_ratio.length < 2 ? "markers" : "lines";
  return curves.map(([name, title], i) => {
    // what has a closed form is drawn between the study's frequencies too
    const { frequency_ratio = [], [name]: values = [] } = name in answer.exact ? answer.exact : answer;
    return {
      type: "scatter",
      mode,
      x: frequency_ratio.map((r) => r * shown.factor(FREQUENCY)),
      y: values.map((x) => (x === null ? null : x * shown.factor("amplitude_ratio"))),
      name: title,
      line: { color: CURVES()[i], dash: DASHES[i], width: 2 },
      marker: { size: 10, symbol: ["circle", "square", "diamond"][i], color: CURVES()[i] },
    };
  });
}
