/** Shows and edits the name, tags and note of a study, and the name of a design. */
/** @import { Design, StudyRecord } from "./types.js" */

import { ask, designPath, refusalBox, studyPath } from "./api.js";
import { button, el, fill, quiet, say } from "./dom.js";
import { WORDS } from "./words.js";

export const TAG = new RegExp(`^(?:${WORDS.tag_pattern})$`);

/**
 * The tags of a study, as buttons. A click on a tag shows all studies with this tag.
 *
 * @param {string[]} tags
 * @param {(tag: string) => void} choose
 */
export function tagList(tags, choose) {
  return (
    tags.length > 0 &&
    el(
      "div",
      { class: "tags" },
      tags.map((tag) =>
        button(tag, () => choose(tag), { class: "tag", "aria-label": `Studies with the tag ${tag}` }),
      ),
    )
  );
}

/**
 * A form for the name, the tags and the note of a study.
 *
 * @param {StudyRecord} record
 * @param {(name: string) => void} renamed called with the stored name
 */
export function remarksForm(record, renamed) {
  const name = nameBox(record.name);
  const tags = el("input", {
    class: "wide",
    value: record.tags.join(", "),
    placeholder: "rig-2, steel",
    autocomplete: "off",
  });
  const note = el("textarea", { class: "wide", rows: 4, value: record.note, maxlength: 4000 });
  const fields = { Name: name, "Tags, separated by commas": tags, Note: note };
  return savedForm("Name, tags and note", fields, async () => {
    const said = { name: name.value, tags: tags.value.split(/[\s,]+/).filter(Boolean), note: note.value };
    const odd = said.tags.filter((tag) => !TAG.test(tag));
    if (odd.length) return `${odd.join(", ")}: a tag has ${WORDS.tag_words}.`;
    const now = await change(studyPath(record.id), said);
    Object.assign(record, { name: now.name, tags: now.tags, note: now.note });
    renamed(now.name);
    tags.value = now.tags.join(", ");
  });
}

/**
 * A form for the name of a design.
 *
 * @param {Design} design
 * @param {(name: string) => void} renamed called with the stored name
 */
export function nameForm(design, renamed) {
  const name = nameBox(design.name);
  const form = savedForm("Name", { Name: name }, async () => {
    renamed((await change(designPath(design.id), { name: name.value })).name);
  });
  return el("details", { class: "box" }, el("summary", {}, "Rename"), form);
}

/** @param {string} value */
function nameBox(value) {
  return el("input", { class: "wide", value, maxlength: 200, autocomplete: "off" });
}

/** @template {string} Path @param {Path} path @param {object} said */
function change(path, said) {
  const headers = { "Content-Type": "application/json" };
  return ask(path, {}, { method: "PATCH", body: JSON.stringify(said), headers });
}

/**
 * Fields with a button that saves them.
 *
 * @param {string} what name of the fields
 * @param {Record<string, HTMLElement>} fields by their labels
 * @param {() => Promise<string | void>} save saves the fields, and returns the fault if this fails
 */
function savedForm(what, fields, save) {
  const trouble = el("div");
  const onsubmit = async (/** @type {Event} */ event) => {
    event.preventDefault();
    try {
      const wrong = await save();
      if (wrong) return fill(trouble, el("p", { class: "box fault", role: "alert" }, wrong));
      fill(trouble, quiet("Saved."));
      say(`${what}: saved.`);
    } catch (error) {
      fill(trouble, refusalBox(error));
    }
  };
  return el(
    "form",
    { class: "fields", "aria-label": what, onsubmit },
    Object.entries(fields).map(([label, field]) =>
      el("label", { class: "field wide" }, el("span", {}, label), field),
    ),
    trouble,
    el("div", {}, el("button", { type: "submit" }, `Save ${what[0].toLowerCase()}${what.slice(1)}`)),
  );
}
