/** Name, tags and note of a study: read, and written. */

import { ask, refusalBox, studyPath } from "./api.js";
import { el, fill, say } from "./dom.js";
import { WORDS } from "./words.js";

const TAG = new RegExp(`^(?:${WORDS.tag_pattern})$`);

/**
 * Tags as they stand in a list: a click on one shows the studies that have it.
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
        el(
          "button",
          {
            type: "button",
            class: "tag",
            "aria-label": `Studies with the tag ${tag}`,
            onclick: () => choose(tag),
          },
          tag,
        ),
      ),
    )
  );
}

/**
 * A form for all three.
 *
 * @param {import("./answers.js").StudyRecord} record
 * @param {(name: string) => void} renamed told the name that is kept
 */
export function remarksForm(record, renamed) {
  const tags = el("input", {
    class: "wide",
    value: record.tags.join(", "),
    placeholder: "rig-2, steel",
    autocomplete: "off",
  });
  const name = el("input", { class: "wide", value: record.name, maxlength: 200, autocomplete: "off" });
  const note = el("textarea", { class: "wide", rows: 4, value: record.note, maxlength: 4000 });
  const trouble = el("div");

  /** @param {Event} event */
  async function save(event) {
    event.preventDefault();
    const said = { name: name.value, tags: tags.value.split(/[\s,]+/).filter(Boolean), note: note.value };
    const odd = said.tags.filter((/** @type {string} */ tag) => !TAG.test(tag));
    if (odd.length)
      return fill(
        trouble,
        el("p", { class: "box fault", role: "alert" }, `${odd.join(", ")}: a tag has ${WORDS.tag_words}.`),
      );
    try {
      const now = await ask(
        studyPath(record.id),
        {},
        { method: "PATCH", body: JSON.stringify(said), headers: { "Content-Type": "application/json" } },
      );
      Object.assign(record, { name: now.name, tags: now.tags, note: now.note });
      renamed(now.name);
      tags.value = now.tags.join(", ");
      fill(trouble, el("p", { class: "quiet" }, "Saved."));
      say("Name, tags and note are saved.");
    } catch (error) {
      fill(trouble, refusalBox(error));
    }
  }

  return el(
    "form",
    { class: "fields", "aria-label": "Name, tags and note", onsubmit: save },
    el("label", { class: "field wide" }, el("span", {}, "Name"), name),
    el("label", { class: "field wide" }, el("span", {}, "Tags, with commas between them"), tags),
    el("label", { class: "field wide" }, el("span", {}, "Note"), note),
    trouble,
    el("div", {}, el("button", { type: "submit" }, "Save name, tags and note")),
  );
}
