/** Views at addresses below `#/designs`: the list of designs, the form of a new design, and one design. */
/** @import { DesignSummary, View } from "./types.js" */

import { el, fill, heading } from "./dom.js";
import { designView, spelledWorst } from "./design.js";
import { designForm } from "./design_form.js";
import { Filter } from "./filter.js";
import { help } from "./help.js";
import { Kept } from "./kept.js";
import { count } from "./numbers.js";
import { badge } from "./progress.js";
import { Shelf } from "./shelf.js";

/** @type {View} */
export function designsView(root, address) {
  const [first, ...rest] = address.parts;
  if (first === "new") return designForm(root, { ...address, parts: rest });
  return first ? designView(root, address) : designList(root, address.query);
}

/** @param {HTMLElement} root @param {URLSearchParams} query */
async function designList(root, query) {
  const list = el("div", { class: "studies" });
  const kept = new Kept("#/designs", query);
  const filter = new Filter(kept, () => shelf.look());
  fill(
    root,
    heading("Designs", el("a", { class: "button primary", href: "#/designs/new" }, "New design")),
    el(
      "p",
      { class: "quiet about" },
      help("how-to/design/", "designs"),
      "From a structure, its limits and the allowed dampers to a damper in drawing values.",
    ),
    filter.form("Designs"),
    list,
  );
  const none = () =>
    filter.isUsed()
      ? "No design matches the search."
      : "No designs yet. A new one begins with a specification.";
  /** @type {Shelf<DesignSummary>} */
  const shelf = new Shelf(list, filter.row, {
    kind: "designs",
    kept,
    filter,
    none: () => el("p", { class: "box" }, none()),
    says: ({ message }) => [message && el("div", { class: "quiet" }, message)],
    state: ({ state, points }) => [
      badge(state),
      el("span", { class: "progress" }, `${count(points)} points`),
    ],
    best: async ({ known }) =>
      known && { value: known.worst.value, unit: known.worst.units, text: spelledWorst(known) },
  });
  await shelf.look();
  return () => shelf.leave();
}
