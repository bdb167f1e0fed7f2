/** Requests the value of a study's best damper for lists, once for each revision of the study. */
/** @import { Best, StudyRecord } from "./types.js" */

import { ask, Refusal, studyPath } from "./api.js";
import { leading, VALUE } from "./headline.js";
import { drawn } from "./numbers.js";
import { Shown } from "./shown.js";
import { LARGEST } from "./thumbnail.js";

/** Values by study and revision. @type {Map<string, Promise<Best | null>>} */
const known = new Map();

/**
 * @param {StudyRecord} record record as in the list of studies
 * @returns {Promise<Best | null>} null if the study has no best damper yet, or is too large
 */
export function bestOf(record) {
  if (record.points_done < record.points_total || record.points_total > LARGEST) return Promise.resolve(null);
  const key = `${record.id} ${record.revision}`;
  const found = known.get(key) ?? asked(record.id);
  known.set(key, found);
  return found;
}

/** @param {string} id */
async function asked(id) {
  try {
    const [ranked, { in_units }] = await Promise.all([
      ask(studyPath(id, "optimal-designs"), { top: 1 }),
      ask(studyPath(id, "axes")),
    ]);
    const { best } = leading(ranked);
    return best && spelledBest(ranked.units, best.value, new Shown(in_units));
  } catch (error) {
    // the study stores no amplitude, or was deleted
    if (error instanceof Refusal) return null;
    throw error;
  }
}

/**
 * The best value with its unit, and as the text that is shown.
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
