/** The results of a study that can be shown. */
/** @import { Session, Variable } from "./types.js" */

import { picker } from "./dom.js";
import { AMPLITUDE, RECORD } from "./selection.js";
import { inBrackets } from "./shown.js";
import { WORDS } from "./words.js";

/**
 * Results of a study. Results of a suite are in units. Results of a study over base amplitudes are in units
 * if the study is shown in units, otherwise ratios.
 *
 * @param {Session} session @returns {Variable[]}
 */
export function measures({ words, variables, shown, selection }) {
  if (RECORD in selection.axes) return words.suite.variables;
  if (!(AMPLITUDE in selection.axes)) return words.variables.filter((one) => variables.includes(one.name));
  const lengths = Object.entries(WORDS.results_in_units).filter(([name]) => variables.includes(name));
  const hidden = shown.inUnits ? lengths.map(([, [source]]) => source) : [];
  const plain = words.variables.filter((one) => variables.includes(one.name) && !hidden.includes(one.name));
  const inUnits = lengths.map(([name, [, long_name, units]]) => ({ name, long_name, units, coded: false }));
  return shown.inUnits ? [...inUnits, ...plain] : plain;
}

/** The name of a result, with its shown unit. @param {{long_name: string, units: string}} variable */
export function unitOf({ long_name, units }) {
  return long_name + inBrackets(units);
}

const USUAL = "amplitude_ratio";

/**
 * The choice of a result, which is kept in the address. Results that are codes are not offered.
 *
 * @param {Session} session
 * @param {string} key in the address
 * @param {() => void} look called after a choice
 */
export function chosenMeasure({ words, variables, kept, shown }, key, look) {
  const offered = words.variables.filter((one) => variables.includes(one.name) && !one.coded);
  const names = offered.map((one) => one.name);
  const choice = { name: kept.one(key, names, USUAL) };
  const texts = /** @type {[string, string][]} */ (
    offered.map((one) => [one.name, shown.variable(one.name, one.long_name)])
  );
  const element = picker("Result", texts, choice.name, (name) => {
    choice.name = name;
    kept.keep({ [key]: name === USUAL ? null : name });
    look();
  });
  return { element, get: () => choice.name };
}
