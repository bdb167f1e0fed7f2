/**
 * Compares several studies or designs: a table of their best dampers, and a figure of the responses of these
 * dampers over the band.
 *
 * @typedef {{r: number[], ratio: (number | null)[], hertz: number | null, millimetres: number | null}} Curve
 *   response as ratios, with the factors that convert frequency and amplitude to units
 * @typedef {{name: string, href: string, best: string, damper: string, curve: Curve | null}} Compared
 */
/** @import { DesignAnswer, View } from "./types.js" */

import { ask, designPath, studyPath } from "./api.js";
import { spelledBest } from "./best.js";
import { spelledDamper, spelledWorst } from "./design.js";
import { el, fill, grid, quiet } from "./dom.js";
import { CURVES, DASHES, Figure } from "./figure.js";
import { leading } from "./headline.js";
import { FREQUENCY } from "./selection.js";
import { MOST_COMPARED, nameOf } from "./shelf.js";
import { Shown } from "./shown.js";
import { WORDS } from "./words.js";

const { accelerations } = WORDS.specification.tables;
const AMPLITUDE_RATIO = "amplitude_ratio";

/** @type {View} */
export async function compareView(root, { query }) {
  const ids = (/** @type {string} */ kind) => (query.get(kind) ?? "").split(",").filter(Boolean);
  const asked = [...ids("studies").map(ofStudy), ...ids("designs").map(ofDesign)].slice(0, MOST_COMPARED);
  const found = await Promise.all(asked);
  const chart = new Figure({
    label: "Responses of the best dampers over the band",
    name: "compared",
    height: 420,
  });
  const drawn = found.filter(({ curve }) => curve);
  const units = drawn.every(({ curve }) => curve?.hertz && curve.millimetres);
  const scaled = (
    /** @type {(number | null)[] | undefined} */ values,
    /** @type {number | null | undefined} */ by,
  ) => values?.map((value) => (value === null || !units ? value : value * (by ?? 1)));
  fill(
    root,
    el("h1", {}, "Compare"),
    el(
      "section",
      { class: "box" },
      grid(
        "Compared",
        ["Name", "Best value", "Damper"],
        found.map(({ name, href, best, damper }) => [el("a", { href }, name), best, damper]),
      ),
    ),
    drawn.length > 0 && chart.element,
    drawn.length < found.length && quiet("Only responses that are displacements over a band are drawn."),
  );
  if (drawn.length === 0) return;
  await chart.draw(
    () =>
      drawn.map(({ name, curve }, i) => ({
        x: scaled(curve?.r, curve?.hertz),
        y: scaled(curve?.ratio, curve?.millimetres),
        name,
        mode: "lines",
        line: { color: CURVES()[i], dash: DASHES[i], width: 2 },
      })),
    () => ({
      xaxis: { title: units ? "frequency [Hz]" : "frequency ratio r" },
      yaxis: { title: units ? "displacement [mm]" : "amplitude ratio X/Z", rangemode: "tozero" },
    }),
  );
}

/** @param {string} id @returns {Promise<Compared>} */
async function ofStudy(id) {
  const [record, { in_units }, ranked] = await Promise.all([
    ask(studyPath(id)),
    ask(studyPath(id, "axes")),
    ask(studyPath(id, "optimal-designs"), { top: 1 }),
  ]);
  const { best } = leading(ranked);
  const shown = new Shown(in_units);
  const several = record.dimensions.filter((_, i) => record.shape[i] > 1);
  const at = several.flatMap((name) =>
    name === FREQUENCY || best?.[name] === undefined ? [] : [/** @type {const} */ ([name, best[name]])],
  );
  const hasBand = best && ranked.units === "1" && several.includes(FREQUENCY);
  return {
    name: nameOf(record),
    href: `#/studies/${id}`,
    best: best ? spelledBest(ranked.units, best.value, shown).text : "–",
    damper: at.map(([name, value]) => `${shown.called(name)} ${shown.value(name, value)}`).join(", ") || "–",
    curve: hasBand ? await response(id, Object.fromEntries(at), shown) : null,
  };
}

/** @param {string} id @param {Record<string, number>} at @param {Shown} shown @returns {Promise<Curve>} */
async function response(id, at, shown) {
  const answer = await ask(studyPath(id, "frequency-response"), at);
  const factor = (/** @type {string} */ name) => (shown.has(name) ? shown.factor(name) : null);
  const { frequency_ratio: r, values: ratio } = answer;
  return { r, ratio, hertz: factor(FREQUENCY), millimetres: factor(AMPLITUDE_RATIO) };
}

/** @param {string} id @returns {Promise<Compared>} */
async function ofDesign(id) {
  const design = await ask(designPath(id));
  const { answer } = design;
  const { known } = answer ? { known: answer } : design;
  return {
    name: nameOf(design),
    href: `#/designs/${id}`,
    best: known ? spelledWorst(known) : "–",
    damper: known ? spelledDamper(known.design) : "–",
    curve:
      answer && !accelerations.includes(answer.worst.measure) && answer.response.value
        ? overBand(answer)
        : null,
  };
}

/** @param {DesignAnswer} answer @returns {Curve} */
function overBand({ response: { frequency_ratio: r, frequency_hz: hz, value }, worst }) {
  const over = worst.units === "m" ? (worst.ratio ?? NaN) / worst.value : 1;
  return {
    r,
    ratio: (value ?? []).map((one) => (one === null ? null : one * over)),
    hertz: hz ? hz[0] / r[0] : null,
    millimetres: worst.units === "m" ? 1000 / over : null,
  };
}
