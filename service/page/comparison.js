/** Compares the study's damper with a tuned mass damper, which the user can detune. */
/** @import { Comparison, Session, Shown, Tab } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, el, fill, picker, prose } from "./dom.js";
import { CURVES, DASHES, Figure } from "./figure.js";
import { judgedOver } from "./headline.js";
import { help } from "./help.js";
import { short } from "./numbers.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { times } from "./shown.js";
import { sliders } from "./sliders.js";
import { TUNINGS } from "./vocabulary.js";

const FARTHEST = 0.5;
const USUAL = "minimax";

/** @type {Tab} */
export function comparisonTab(session, place) {
  new ComparisonTab(session).drawIn(place);
}

class ComparisonTab {
  answer = el("div", { class: "ratio", role: "status" });
  note = el("p", { class: "quiet note" });
  meaning = el("p", { class: "quiet" });
  number = 0;

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    const { kept, words, record, selection, changes } = session;
    this.asked = {
      criterion: kept.one("criterion", Object.keys(words.tunings), USUAL),
      detuning: kept.number("detuning", -FARTHEST, FARTHEST, 0),
      damping_detuning: kept.number("damping_detuning", -FARTHEST, FARTHEST, 0),
      /** @type {number | null} */ tmd_mass_ratio: kept.number("tmd_mass_ratio", 0, Infinity, 0) || null,
    };
    this.chart = new Figure({
      label: "Frequency responses: the study's damper, a tuned mass damper, no damper",
      name: `tmd-${record.id}`,
      height: 420,
      python: () => pythonLine(record.id, "tmd_comparison", this.question()),
    });
    this.look = debounced(150, () => this.ask());
    selection.addEventListener("chosen", this.look);
    changes.addEventListener("grown", this.look);
  }

  /** @param {HTMLElement} place */
  drawIn(place) {
    const { asked, session } = this;
    const { shown, selection } = session;
    fill(
      place,
      el(
        "div",
        { class: "study" },
        el("div", { class: "left" }, this.answer, this.chart.element, this.note),
        el(
          "section",
          { class: "box" },
          help("notebooks/tuned-mass-damper/", "comparing with a tuned mass damper"),
          el("h2", {}, "Tuned mass damper"),
          picker("Tuned by", TUNINGS, asked.criterion, (criterion) => this.change({ criterion })),
          this.meaning,
          share("Frequency off by", asked.detuning, (detuning) => this.change({ detuning })),
          share("Damping off by", asked.damping_detuning, (off) => this.change({ damping_detuning: off })),
          this.massField(),
          sliders(selection, shown, true),
        ),
      ),
    );
    this.look();
  }

  massField() {
    const { shown } = this.session;
    const { tmd_mass_ratio: now } = this.asked;
    const by = shown.factor("mass_ratio");
    const oninput = () => this.change({ tmd_mass_ratio: mass.value === "" ? null : Number(mass.value) / by });
    const value = now === null ? "" : short(now * by, 12);
    const looks = { type: "number", step: "any", min: 0, placeholder: "as the design", value, oninput };
    const mass = el("input", looks);
    const label = shown.has("mass_ratio") ? "Mass of the tuned mass damper [kg]" : "Mass ratio μ";
    return el("label", { class: "field" }, el("span", {}, label), mass);
  }

  question() {
    return { ...this.session.selection.at([FREQUENCY]), ...this.asked };
  }

  /** @param {Partial<typeof this.asked>} what */
  change(what) {
    Object.assign(this.asked, what);
    const { criterion, detuning, damping_detuning, tmd_mass_ratio } = this.asked;
    // the address is set before the request, because the user may open another tab meanwhile
    this.session.kept.keep({
      criterion: criterion === USUAL ? null : criterion,
      detuning: detuning || null,
      damping_detuning: damping_detuning || null,
      tmd_mass_ratio,
    });
    this.look();
  }

  async ask() {
    const mine = ++this.number;
    const { record, shown } = this.session;
    try {
      const answer = await ask(studyPath(record.id, "tmd-comparison"), this.question());
      if (mine !== this.number) return;
      const further = judgedOver(record.id, shown, answer.next_frequencies);
      fill(this.answer, verdict(answer, shown), el("p", {}, further));
      fill(this.note, prose(shown.words(answer).note));
      this.meaning.textContent = answer.criterion_means;
      await this.chart.draw(
        () => traces(answer, shown),
        () => layout(shown),
      );
    } catch (error) {
      if (mine === this.number) fill(this.answer, refusalBox(error));
    }
  }
}

/** @param {Shown} shown */
function layout(shown) {
  const amplitude = shown.variable("amplitude_ratio", "amplitude ratio X/Z");
  return {
    xaxis: { title: shown.frequency() },
    yaxis: { title: amplitude, type: "log", dtick: "D2" },
  };
}

/**
 * A slider for a share from −50 to 50 per cent.
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
  slider.value = String(percent); // set after the limits, because a browser clips the value to the limits
  return el("label", { class: "slider" }, el("span", {}, label), slider, output);
}

/**
 * The comparison of the two dampers, in sentences and as a ratio.
 *
 * @param {Comparison} answer
 * @param {Shown} shown
 */
function verdict(answer, shown) {
  const sentences = shown.words(answer).verdict.map((sentence) => el("p", {}, prose(sentence)));
  // with too few frequencies, a ratio would be misleading
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
    // a curve with a closed form is also drawn between the frequencies of the study
    const { frequency_ratio = [], [name]: values = [] } = name in answer.exact ? answer.exact : answer;
    return {
      type: "scatter",
      mode,
      x: times(frequency_ratio, shown.factor(FREQUENCY)),
      y: times(values, shown.factor("amplitude_ratio")),
      name: title,
      line: { color: CURVES()[i], dash: DASHES[i], width: 2 },
      marker: { size: 10, symbol: ["circle", "square", "diamond"][i], color: CURVES()[i] },
    };
  });
}
