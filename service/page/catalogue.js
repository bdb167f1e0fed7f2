/** Every question that a study answers: its meaning, and its name as a command, in Python and over HTTP. */
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
