/** Links to the documentation, if the service offers the documentation. */

import { el } from "./dom.js";

/** Address of the documentation; empty if the service has none. */
const PLACE = document.documentElement.dataset.docs ?? "";

/**
 * A link that opens a page of the documentation in a new tab.
 *
 * @param {string} page address of the page within the documentation
 * @param {string} about subject of the page
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

/** The link to the documentation in the navigation. */
export function documentationLink() {
  return PLACE !== "" && el("a", { href: PLACE, target: "_blank", rel: "noopener" }, "Documentation");
}
