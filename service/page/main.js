/**
 * Shows the view of each address, which is the fragment of the page's URL.
 *
 * @typedef {(() => void) | void} Leave
 * @typedef {(root: HTMLElement, address: {parts: string[], query: URLSearchParams}) => Promise<Leave>} View
 */

import { KEY_NEEDED, refusalBox } from "./api.js";
import { el, fill, say } from "./dom.js";
import { accuracyView } from "./accuracy.js";
import { compareView } from "./compare.js";
import { designsView } from "./design_list.js";
import { earthquakeView } from "./earthquake.js";
import { fitView } from "./fit.js";
import { documentationLink } from "./help.js";
import { showSession, signInForm } from "./sign_in.js";
import { studiesView } from "./studies.js";
import { studyForm } from "./study_form.js";
import { studyView } from "./study.js";

/** @type {Record<string, View>} */
const VIEWS = {
  "": studiesView,
  new: studyForm,
  studies: studyView,
  designs: designsView,
  accuracy: accuracyView,
  compare: compareView,
  earthquake: earthquakeView,
  fit: fitView,
};

/** @type {Leave} */
let leave;
let shown = 0;

async function show() {
  const [path, query = ""] = location.hash.replace(/^#\/?/, "").split("?", 2);
  if (location.hash === "#main") return;
  const parts = path.split("/").map(decoded);
  const mine = ++shown;
  leave?.();
  leave = undefined;
  markCurrent(path);
  const root = el("div", { class: "view" });
  fill(/** @type {HTMLElement} */ (document.getElementById("main")), root);
  const view = VIEWS[parts[0]] ?? nowhere;
  try {
    const leaving = await view(root, { parts: parts.slice(1), query: new URLSearchParams(query) });
    if (mine === shown) leave = leaving;
    else leaving?.();
  } catch (error) {
    fill(
      root,
      el("h1", {}, "This did not work"),
      refusalBox(error),
      el("p", {}, el("a", { href: "#/" }, "All studies")),
    );
  }
  if (mine === shown) arrived(root);
}

/** @param {string} part */
function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

/** Set the window's title and announce the view to screen readers. @param {HTMLElement} root */
function arrived(root) {
  const heading = root.querySelector("h1");
  document.title = heading ? `${heading.textContent} · damperlab` : "damperlab";
  if (heading && document.activeElement === document.body && shown > 1) {
    heading.setAttribute("tabindex", "-1");
    heading.focus({ preventScroll: true });
  }
}

/** @param {string} path */
function markCurrent(path) {
  for (const link of document.querySelectorAll("nav a")) {
    const here = link.getAttribute("href") === `#/${path}`;
    if (here) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
}

/** @type {View} */
async function nowhere(root) {
  fill(root, el("h1", {}, "No such view"), el("p", {}, el("a", { href: "#/" }, "All studies")));
}

/** Show the form for a key in place of the present view, unless it is shown already. */
function signIn() {
  if (document.getElementById("key")) return;
  shown += 1;
  leave?.();
  leave = undefined;
  const root = el("div", { class: "view" }, ...signInForm(show));
  fill(/** @type {HTMLElement} */ (document.getElementById("main")), root);
}

/**
 * Replace a typed comma in a number by a decimal point. The browser would ignore the comma, and read 60,5 as
 * 605.
 *
 * @param {InputEvent} event
 */
function decimalPoint(event) {
  const { target, data } = event;
  if (!(target instanceof HTMLInputElement) || target.type !== "number" || !data?.includes(",")) return;
  event.preventDefault();
  document.execCommand("insertText", false, data.replace(",", "."));
  say("The comma was taken for a decimal point.");
}

document.addEventListener("beforeinput", decimalPoint);
document.querySelector("nav")?.append(documentationLink() || "");
window.addEventListener("hashchange", show);
window.addEventListener(KEY_NEEDED, signIn);
showSession();
show();
