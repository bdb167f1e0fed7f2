/**
 * Functions that make elements. They insert text only as text, so that typed text is never read as markup.
 *
 * @typedef {Record<string, unknown>} Attributes
 */
/** @import { Child } from "./types.js" */

/**
 * Make an element.
 *
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Attributes} [attributes] A function, as for `onclick`, is a listener. `value` and `checked` are set
 *   as properties. true sets an empty attribute; null, undefined and false set none.
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function")
      element.addEventListener(name.slice(2), /** @type {EventListener} */ (value));
    else if (name === "value" || name === "checked") Object.assign(element, { [name]: value });
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...texts(children));
  if (element instanceof HTMLSelectElement && "value" in attributes) element.value = String(attributes.value);
  return element;
}

/** @param {Child[]} children @returns {(Node | string)[]} */
function texts(children) {
  return /** @type {Exclude<Child, Child[]>[]} */ (/** @type {unknown[]} */ (children).flat(Infinity))
    .filter((child) => child !== null && child !== undefined && child !== false)
    .map((child) => (child instanceof Node ? child : String(child)));
}

/** Replace the children of an element. @param {Element} element @param {...Child} children */
export function fill(element, ...children) {
  element.replaceChildren(...texts(children));
}

/** The title of a view, with further elements beside it. @param {string} title @param {...Child} beside */
export function heading(title, ...beside) {
  return el("div", { class: "row spread" }, el("h1", {}, title), ...beside);
}

/** A box of a view with a heading. @param {string} title @param {...Child} children */
export function box(title, ...children) {
  return el("section", { class: "box" }, el("h2", {}, title), ...children);
}

/** A paragraph in small grey type. @param {...Child} children */
export function quiet(...children) {
  return el("p", { class: "quiet" }, ...children);
}

/** A part of a view that a user can open and close. @param {string} title @param {...Child} children */
export function details(title, ...children) {
  return el("details", {}, el("summary", {}, title), ...children);
}

/** @param {Child} text @param {() => void} onclick @param {Attributes} [looks] */
export function button(text, onclick, looks = {}) {
  return el("button", { type: "button", onclick, ...looks }, text);
}

/** A small button. @param {Child} text @param {() => void} onclick @param {string} [says] spoken label */
export function smallButton(text, onclick, says) {
  return button(text, onclick, { class: "small", "aria-label": says });
}

/** A list of names with values. @param {[string, Child][]} entries @param {string} [kind] "numbers": large */
export function facts(entries, kind = "") {
  const rows = entries.map(([name, value]) => el("div", {}, el("dt", {}, name), el("dd", {}, value)));
  return el("dl", { class: `facts ${kind}`.trim() }, rows);
}

/**
 * A select with its label.
 *
 * @param {string} label
 * @param {[string, string][]} options value and text of each option
 * @param {string} value
 * @param {(value: string) => void} onChange
 */
export function picker(label, options, value, onChange) {
  const select = el(
    "select",
    { onchange: () => onChange(select.value) },
    options.map(([key, text]) => el("option", { value: key, selected: key === value }, text)),
  );
  return el("label", { class: "field" }, el("span", {}, label), select);
}

/**
 * A check box with its label.
 *
 * @param {string} label
 * @param {boolean} checked
 * @param {(checked: boolean) => void} onChange
 */
export function checkbox(label, checked, onChange) {
  const box = el("input", { type: "checkbox", checked, onchange: () => onChange(box.checked) });
  return el("label", { class: "check" }, box, label);
}

/**
 * A table. A table that is wider than the page scrolls separately.
 *
 * @param {string} title for screen readers
 * @param {Child[]} columns heads of the columns
 * @param {Child[][]} rows
 * @param {boolean} [named] whether the first cell of a row is the head of the row
 * @returns {HTMLElement}
 */
export function grid(title, columns, rows, named = true) {
  const cell = (/** @type {Child} */ each, /** @type {number} */ i) =>
    named && i === 0 ? el("th", { scope: "row" }, each) : el("td", {}, each);
  const heads = columns.map((each) => el("th", { scope: "col" }, each));
  const body = rows.map((row) => el("tr", {}, row.map(cell)));
  return el(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": title },
    el("table", {}, el("thead", {}, el("tr", {}, heads)), el("tbody", {}, body)),
  );
}

/**
 * A sentence of the service, in which text between backticks is shown as code.
 *
 * @param {string} text
 * @returns {Child[]}
 */
export function prose(text) {
  return text.split("`").map((part, i) => (i % 2 ? el("code", {}, part) : part));
}

/** A sentence with a capital first letter. @param {string} text */
export function capital(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** Announce a text to screen readers. @param {string} text */
export function say(text) {
  const place = document.getElementById("said");
  if (place) place.textContent = text;
}

/**
 * Ask for confirmation before an action that cannot be undone.
 *
 * @param {string} title
 * @param {string} text
 * @param {string} action label of the button
 * @returns {Promise<boolean>}
 */
export function confirmed(title, text, action) {
  return new Promise((resolve) => {
    const dialog = el(
      "dialog",
      { "aria-labelledby": "asked", onclose: () => (dialog.remove(), resolve(dialog.returnValue === "yes")) },
      el("h2", { id: "asked" }, title),
      el("p", {}, text),
      el(
        "div",
        { class: "row end" },
        button("Keep it", () => dialog.close("no"), { autofocus: true }),
        button(action, () => dialog.close("yes"), { class: "danger" }),
      ),
    );
    document.body.append(dialog);
    dialog.showModal();
  });
}

/**
 * Delay the call of a function until no further call has come for some time.
 *
 * @template {unknown[]} A
 * @param {number} milliseconds
 * @param {(...given: A) => void} run
 * @returns {(...given: A) => void}
 */
export function debounced(milliseconds, run) {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  return (...given) => {
    clearTimeout(timer);
    timer = setTimeout(() => run(...given), milliseconds);
  };
}

/**
 * Parse typed JSON. If the text is not an object, return null, show the fault and disable the button.
 *
 * @param {HTMLTextAreaElement} text
 * @param {HTMLElement} wrong where the fault is shown
 * @param {HTMLButtonElement} submit
 */
export function typedObject(text, wrong, submit) {
  try {
    const document = JSON.parse(text.value);
    if (document === null || typeof document !== "object" || Array.isArray(document))
      throw new Error("{ } is needed");
    wrong.textContent = "";
    submit.disabled = false;
    return document;
  } catch (error) {
    wrong.textContent = `This is not JSON yet: ${error instanceof Error ? error.message : error}`;
    submit.disabled = true;
    return null;
  }
}
