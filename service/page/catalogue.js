/** Table of the questions that a study answers, with the command, the Python method and the route of each. */
/** @import { StudyRecord } from "./types.js" */

import { el, grid } from "./dom.js";
import { kindOf } from "./vocabulary.js";
import { WORDS } from "./words.js";

/** @param {StudyRecord} record */
export function catalogue({ dimensions }) {
  const kind = kindOf(dimensions);
  const rows = WORDS.questions
    .filter(({ kinds }) => kinds.includes(kind))
    .map(({ summary, command, method, route }) => {
      const names = [`damperlab ${command}`, `.${method}()`, `/${route}`];
      return [summary, ...names.map((name) => el("code", {}, name))];
    });
  return grid("Every question that the study answers", ["Question", "Command", "Python", "HTTP"], rows);
}
