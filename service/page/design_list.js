/**
 * The list of designs, and which view an address below it shows: the list, the form of a new one, or one
 * design.
 */

import { ask, refusalBox } from "./api.js";
import { el, fill } from "./dom.js";
import { designView } from "./design.js";
import { designForm } from "./design_form.js";
import { help } from "./help.js";
import { count, moment } from "./numbers.js";
import { badge, isActive } from "./progress.js";

const LOOK_MILLISECONDS = 3000;
const PAGE = 50;

/** @type {import("./main.js").View} */
export function designsView(root, address) {
  const [first, ...rest] = address.parts;
  if (first === "new") return designForm(root, { ...address, parts: rest });
  return first ? designView(root, address) : designList(root);
}

/** @param {HTMLElement} root */
async function designList(root) {
  const list = el("div", { class: "studies" });
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  let left = false;
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
    list,
  );

  /** @param {string} [cursor] */
  async function look(cursor) {
    clearTimeout(timer);
    try {
      const page = await ask("designs", { limit: PAGE, cursor });
      if (left) return;
      if (cursor) list.querySelector("ul")?.append(...page.designs.map(row));
      else
        fill(
          list,
          page.designs.length
            ? el("ul", { class: "cards" }, page.designs.map(row))
            : el("p", { class: "box" }, "No designs yet. A new one begins with a specification."),
        );
      list.querySelector(".more")?.remove();
      if (page.cursor)
        list.append(
          el("button", { type: "button", class: "more", onclick: () => look(page.cursor) }, "Show more"),
        );
      if (!cursor && page.designs.some((/** @type {any} */ each) => isActive(each.state)))
        timer = setTimeout(look, LOOK_MILLISECONDS);
    } catch (error) {
      if (!left) fill(list, refusalBox(error));
    }
  }

  await look();
  return () => {
    left = true;
    clearTimeout(timer);
  };
}

/** @param {any} design */
function row(design) {
  return el(
    "li",
    { class: "card" },
    el(
      "div",
      { class: "grow" },
      el("a", { class: "title", href: `#/designs/${design.id}` }, design.name || `(no name) ${design.id}`),
      el("div", { class: "quiet" }, `${moment(design.created)} · `, el("code", {}, design.id)),
      design.message && el("div", { class: "quiet" }, design.message),
    ),
    el(
      "div",
      { class: "state" },
      badge(design.state),
      el("span", { class: "progress" }, `${count(design.points)} points`),
    ),
  );
}
