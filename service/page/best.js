/** Requests the value of a study's best damper for lists, once for each revision of the study. */
/** @import { Best, StudyRecord } from "./types.js" */

import { ask, Refusal, studyPath } from "./api.js";
import { leading, VALUE } from "./headline.js";
import { drawn } from "./numbers.js";
import { Shown } from "./shown.js";
import { LARGEST } from "./thumbnail.js";
import { Turns } from "./turns.js";

/** Values by study and revision. @type {Map<string, Promise<Best | null>>} */
const known = new Map();
/** One request at a time. The browser's other connections stay free for the next requests of the user. */
const turns = new Turns(1);

/**
 * @param {StudyRecord} record record as in the list of studies
 * @param {AbortSignal} leaving aborted when the user leaves the list
 * @returns {Promise<Best | null>} null if the study has no best damper yet or is too large, or if the user
 *   has left the list
 */
export function bestOf(record, leaving) {
  if (record.points_done < record.points_total || record.points_total > LARGEST) return Promise.resolve(null);
  const found = known.get(key(record)) ?? turns.run(() => asked(record, leaving));
  known.set(key(record), found);
  return found;
}

/** @param {StudyRecord} record */
function key({ id, revision }) {
  return `${id} ${revision}`;
}

/** @param {StudyRecord} record @param {AbortSignal} signal */
async function asked(record, signal) {
  const { id } = record;
  try {
    const [ranked, { in_units }] = await Promise.all([
      ask(studyPath(id, "optimal-designs"), { top: 1 }, { signal }),
      ask(studyPath(id, "axes"), {}, { signal }),
    ]);
    const { best } = leading(ranked);
    return best && spelledBest(ranked.units, best.value, new Shown(in_units));
  } catch (error) {
    if (signal.aborted) known.delete(key(record));
    // the service refuses if the study stores no amplitude, or was deleted
    else if (!(error instanceof Refusal)) throw error;
    return null;
  }
}

/**
 * The best value, its unit, and the text to show.
 *
 * @param {string} units
 * @param {number} value
 * @param {Shown} shown
 * @returns {Best}
 */
export function spelledBest(units, value, shown) {
  if (units !== "1") return { value, unit: units, text: drawn(value, units, 4) };
  const unit = shown.unit(VALUE);
  return {
    value: value * shown.factor(VALUE),
    unit,
    text: shown.value(VALUE, value, 4) + (unit ? "" : " X/Z"),
  };
}
