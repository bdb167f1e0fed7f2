/** The figures of a design: responses over the band, under several amplitudes, and over the particle mass. */
/** @import { AtAmplitude, DesignAnswer, Frequency, OfMass, OtherName, OverBand, Worst } from "./types.js" */

import { capital } from "./dom.js";
import { colour, CURVES, DASHES, Figure } from "./figure.js";
import { drawn, short } from "./numbers.js";
import { times } from "./shown.js";
import { WORDS } from "./words.js";

/**
 * The scale of the values of a figure.
 *
 * @typedef {{metres: number, unit: string, measure: string, atFrequency: string}} Scale `metres` is the
 *   factor to the shown unit; `measure` names the judged value, `atFrequency` the value at one frequency
 */

/** @typedef {{id: string, answer: DesignAnswer}} Answered */

/** Keys and names of the dampers that are drawn with the damper found. */
const OTHERS = /** @type {[OtherName, string][]} */ ([
  ["tuned_mass_damper", "tuned mass damper of the same mass"],
  ["friction_alone", "friction alone"],
  ["particle_alone", "particle alone"],
]);

/** The title of an axis, without the words "of the structure". @param {string} measure */
const shortOf = (measure) => measure.replace(" of the structure", "");

/** @param {Frequency} of */
const frequencies = (of) => of.frequency_hz ?? of.frequency_ratio;

/** @param {Frequency} of */
const frequencyTitle = (of) => (of.frequency_hz ? "frequency [Hz]" : "frequency ratio r");

/**
 * Draw the responses of the damper found and of others, without tolerances, under the largest amplitude.
 *
 * @param {Answered} design
 * @param {Scale} scale
 */
export function overBand(design, { metres, unit, atFrequency }) {
  const { answer } = design;
  const chart = new Figure({
    label:
      `Response over the band under the largest amplitude: ${calledOf(answer)}, as drawn, and others`,
    name: `design-${design.id}`,
    height: 420,
  });
  const curve = (/** @type {OverBand} */ response) => ({
    x: frequencies(response),
    y: times(response.value ?? [], metres),
  });
  const others = OTHERS.flatMap(([key, name]) => {
    const response = answer[key]?.response;
    return response?.value && !isItself(answer, key) ? [{ ...curve(response), name }] : [];
  });
  chart.draw(
    () => [
      {
        ...curve(answer.response),
        mode: "lines+markers",
        marker: { size: 4 },
        line: { color: CURVES()[0], width: 2.5 },
        name: calledOf(answer),
      },
      ...others.map((each, i) => ({
        ...each,
        mode: "lines",
        line: { color: CURVES()[i + 1], dash: DASHES[i + 1], width: 1.8 },
      })),
    ],
    () => ({
      xaxis: { title: frequencyTitle(answer.response) },
      yaxis: { title: `${shortOf(atFrequency)} [${unit}]`, rangemode: "tozero" },
    }),
  );
  return chart.element;
}

/**
 * Draw the response of the damper found at each amplitude, from half the smallest to twice the largest.
 *
 * @param {string} id of the design
 * @param {AtAmplitude[]} rows
 */
export function overAmplitudes(id, rows) {
  const label =
    "Response over the frequency, of the damper as drawn, under amplitudes of the excitation from " +
    "half the smallest to twice the largest";
  const chart = new Figure({ label, name: `amplitudes-${id}`, height: 460 });
  const moved = rows.filter((row) => row.worst_ratio > 0);
  const largest = {
    x: moved.map((row) => row.worst_frequency_hz ?? row.worst_frequency_ratio),
    y: moved.map((row) => row.worst_ratio),
    mode: "lines+markers",
    name: "largest",
    line: { color: colour("ink"), dash: "dash", width: 1 },
    marker: { size: 6, color: colour("ink") },
  };
  chart.draw(
    () => [
      ...rows.map((row, i) => ({
        x: frequencies(row),
        y: row.ratio,
        mode: "lines",
        name: level(row) + (row.asked ? ", asked for" : ""),
        line: {
          color: between(i / Math.max(1, rows.length - 1)),
          dash: row.asked ? "solid" : "dot",
          width: row.asked ? 2.5 : 1.8,
        },
      })),
      ...(moved.length > 0 ? [largest] : []),
    ],
    () => ({
      xaxis: { title: frequencyTitle(rows[0]) },
      yaxis: {
        title:
          "response over " +
          (rows[0].amplitude_units === "N" ? "static displacement" : "base amplitude") +
          (rows[0].units === "m/s²" ? " times ω_n²" : ""),
        type: "log",
        dtick: "D2",
      },
    }),
  );
  return chart.element;
}

/** @param {AtAmplitude} row */
function level({ amplitude, amplitude_units: units }) {
  return units === "1" ? `${short(amplitude, 3)} times` : drawn(amplitude, units, 3);
}

/** A colour between the colours of the first two curves. @param {number} share */
function between(share) {
  const [first, last] = CURVES()
    .slice(0, 2)
    .map((each) => [1, 3, 5].map((at) => parseInt(each.slice(at, at + 2), 16)));
  return `rgb(${first.map((part, i) => Math.round(part + share * (last[i] - part))).join(", ")})`;
}

/**
 * Draw the response of the best damper over the mass of the particle, and of other dampers of equal mass.
 *
 * @param {string} id of the design
 * @param {OfMass[]} rows
 * @param {Scale} scale
 */
export function againstMass(id, rows, { metres, unit, measure }) {
  const chart = new Figure({
    label: "The best response found for every mass, as drawn, and the response with a tuned mass " +
      "damper of that mass",
    name: `masses-${id}`,
    height: 420,
  });
  const x = rows.map((each) => each.particle_mass_kg ?? each.mass_ratio);
  const values = {
    "best found, as drawn": rows.map((each) => each.worst.value),
    "tuned mass damper": rows.map((each) => each.tuned_mass_damper),
    "particle alone": rows.map((each) => each.particle_alone),
  };
  const drawn = Object.entries(values).filter(([, each]) => each.some((value) => value !== null));
  chart.draw(
    () =>
      drawn.map(([name, each], i) => ({
        x,
        y: times(each, metres),
        mode: "lines+markers",
        name,
        line: { color: CURVES()[i], dash: DASHES[i] },
        marker: { size: 8, symbol: ["circle", "square", "diamond"][i] },
      })),
    () => ({
      xaxis: { title: rows[0].particle_mass_kg === undefined ? "mass ratio β" : "mass of the particle [kg]" },
      yaxis: {
        title: `${capital(shortOf(isMean(rows[0].worst) ? measure : `worst ${measure}`))} [${unit}]`,
        rangemode: "tozero",
      },
    }),
  );
  return chart.element;
}

/** Whether the specification gives every quantity of the damper. @param {DesignAnswer} answer */
export function given(answer) {
  return !Object.keys(answer.specification.choose ?? {}).length;
}

/** The name of the damper found; older answers have no name. @param {DesignAnswer} answer */
export function calledOf(answer) {
  return answer.called ?? (given(answer) ? "as given" : "recommended");
}

/** Whether the verdict recommends another damper, or no damper. @param {DesignAnswer} answer */
export function isBeaten(answer) {
  return !["recommended", "as given"].includes(calledOf(answer));
}

/**
 * Whether another damper, given by its key, is the same as the damper found. For example, a damper without a
 * particle is the same as friction alone.
 *
 * @param {DesignAnswer} answer
 * @param {string} name
 */
export function isItself({ design }, name) {
  const mass = design.particle_mass_kg ?? design.mass_ratio;
  const friction = design.friction_force_n ?? design.friction_ratio;
  return (name === "friction_alone" && mass === 0) || (name === "particle_alone" && friction === 0);
}

/** Whether the judged value is the rms over the band. @param {Worst} worst */
export function isMean(worst) {
  return worst.measure in WORDS.specification.tables.at_a_frequency;
}
