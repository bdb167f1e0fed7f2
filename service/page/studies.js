/** The list of studies, which can be searched and is kept up to date; an empty list shows help. */
/** @import { StudyRecord, View } from "./types.js" */

import { bestOf } from "./best.js";
import { el, fill, heading, prose } from "./dom.js";
import { prepareFigures } from "./figure.js";
import { StudyFilter } from "./filter.js";
import { Kept } from "./kept.js";
import { badge, outdatedNote, progressBar } from "./progress.js";
import { tagList } from "./remarks.js";
import { Shelf } from "./shelf.js";
import { thumbnail } from "./thumbnail.js";
import { vocabulary } from "./vocabulary.js";

/** @type {View} */
export async function studiesView(root, { query }) {
  const list = el("div", { class: "studies" });
  const kept = new Kept("#/", query);
  const filter = new StudyFilter(kept, () => shelf.look());
  fill(
    root,
    heading("Studies", el("a", { class: "button primary", href: "#/new" }, "New study")),
    filter.form("Studies", filter.more),
    list,
  );
  /** @type {Shelf<StudyRecord>} */
  const shelf = new Shelf(list, filter.row, {
    kind: "studies",
    kept,
    filter,
    none: () => (filter.isUsed() ? nothingFound() : nothingYet()),
    picture: (record) => !filter.gone() && thumbnail(record),
    says: (record) => [
      record.submitted_by && el("div", { class: "quiet" }, `by ${record.submitted_by}`),
      record.priority !== 0 && el("div", { class: "quiet" }, `priority ${record.priority}`),
      record.message && el("div", { class: "quiet" }, record.message),
      tagList(record.tags, (tag) => filter.tagged(tag)),
      outdatedNote(record),
    ],
    state: (record) => [badge(record.state), progressBar(record)],
    best: bestOf,
  });
  await shelf.look();
  if (shelf.records.length) prepareFigures();
  return () => shelf.leave();
}

function nothingFound() {
  return el("p", { class: "box" }, "No study matches the search.");
}

async function nothingYet() {
  const { studies } = await vocabulary();
  return el(
    "div",
    { class: "box" },
    el("h2", {}, "No studies yet"),
    el(
      "p",
      {},
      "A study computes a damper’s response over a grid of designs. Start from a scene of the paper, " +
        "change what you like, and watch its map fill.",
    ),
    el(
      "p",
      {},
      "You know the structure, in kg, Hz and mm, and want a damper for it? ",
      el("a", { href: "#/designs/new" }, "Specify a design"),
      ": the structure, its limits and the ranges of the damper, in the units of a drawing.",
    ),
    el(
      "ul",
      { class: "scenes" },
      studies.map((scene) =>
        el(
          "li",
          {},
          el("a", { href: `#/new?scene=${encodeURIComponent(scene.name)}` }, scene.name),
          " ",
          el("span", { class: "quiet" }, prose(firstSentence(scene.about[0]))),
        ),
      ),
    ),
  );
}

/** @param {string} text */
function firstSentence(text) {
  return text.split(/(?<=[.:]) (?=[A-Z`])/)[0].replace(/:$/, ".");
}
