/** Links to the documentation, if the service has it. */

import { el } from "./dom.js";

/** Its address; empty if the service has no documentation. */
const PLACE = document.documentElement.dataset.docs ?? "";

/**
 * A link to a page of the documentation, opened in a new tab.
 *
 * @param {string} page its address within the site
 * @param {string} about its subject
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

/** The link as an entry of the navigation. */
export function documentationLink() {
  return PLACE !== "" && el("a", { href: PLACE, target: "_blank", rel: "noopener" }, "Documentation");
}
