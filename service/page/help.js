/** Links to the documentation, where the service has it. */

import { el } from "./dom.js";

/** Where it is; empty where the service has none. */
const PLACE = document.documentElement.dataset.docs ?? "";

/**
 * A link to a page of the documentation, in a tab of its own.
 *
 * @param {string} page its address within the site
 * @param {string} about what it tells of
 * @returns {HTMLElement | false}
 */
export function help(page, about) {
  return (
    PLACE !== "" &&
    el(
      "a",
      {
        class: "help",
        href: PLACE + page,
        target: "_blank",
        rel: "noopener",
        title: `Documentation: ${about}`,
        "aria-label": `Documentation: ${about}`,
      },
      "?",
    )
  );
}

/** The same as an entry of the navigation. */
export function documentationLink() {
  return PLACE !== "" && el("a", { href: PLACE, target: "_blank", rel: "noopener" }, "Documentation");
}
