/**
 * The list of designs, and which view an address below it shows: the list, the form of a new one, or one
 * design.
 */

import { el, fill } from "./dom.js";
import { designView, spelledWorst } from "./design.js";
import { designForm } from "./design_form.js";
import { help } from "./help.js";
import { Kept } from "./kept.js";
import { count } from "./numbers.js";
import { badge } from "./progress.js";
import { shelf } from "./shelf.js";

/** @type {import("./main.js").View} */
export function designsView(root, address) {
  const [first, ...rest] = address.parts;
  if (first === "new") return designForm(root, { ...address, parts: rest });
  return first ? designView(root, address) : designList(root, address.query);
}

/** @param {HTMLElement} root @param {URLSearchParams} query */
async function designList(root, query) {
  const list = el("div", { class: "studies" });
  const controls = el("div", { class: "row" });
  fill(
    root,
    el(
      "div",
      { class: "row spread" },
      el("h1", {}, "Designs"),
      el("a", { class: "button primary", href: "#/designs/new" }, "New design"),
    ),
    el(
      "p",
      { class: "quiet about" },
      help("how-to/design/", "designs"),
      "From what must be quiet, and what may be chosen, to a damper in drawing values.",
    ),
    controls,
    list,
  );
  const { look, leave } = shelf(list, controls, {
    kind: "designs",
    kept: new Kept("#/designs", query),
    wanted: () => ({}),
    nothing: () => "",
    none: () => el("p", { class: "box" }, "No designs yet. A new one begins with a specification."),
    says: (/** @type {any} */ design) => [design.message && el("div", { class: "quiet" }, design.message)],
    state: (/** @type {any} */ design) => [
      badge(design.state),
      el("span", { class: "progress" }, `${count(design.points)} points`),
    ],
    best: async (/** @type {any} */ { known }) =>
      known && { value: known.worst.value, unit: known.worst.units, text: spelledWorst(known) },
  });
  await look();
  return leave;
}
