/**
 * A form whose fields and JSON are two views of one document: either can be edited, and the service says what
 * is wrong.
 *
 * @typedef {{name: string, about: string[], definition: any, empty?: boolean}} Start what a form may begin
 *   with
 * @typedef {{document: any, get: (path: string) => any, set: (path: string, value: any) => void, again: () =>
 *   void, put: (document: any) => void}} Held the document by the paths of its fields, where undefined takes
 *   one away; `again` draws the fields anew, `put` puts another document in its place
 * @typedef {{title: string, help: HTMLElement | false, json: string, path: string, submit: string, cost:
 *   string, can: string, starts: Start[], first: string, beside?: HTMLElement, fields: (held: Held) =>
 *   import("./dom.js").Child[], estimated: (answer: any) => import("./dom.js").Child, waits?: () => void,
 *   done: (answer: any) => void}} Form `waits` is called as it is submitted, `done` with the answer
 */

import { Refusal, refusalBox, send } from "./api.js";
import { debounced, el, fill, picker, prose, typedObject } from "./dom.js";
import { showFaults } from "./faults.js";
import { counted } from "./numbers.js";

/**
 * @param {HTMLElement} root
 * @param {Form} form
 * @returns {() => void} leaves it
 */
export function documentForm(root, form) {
  /** @type {unknown} */
  let document_ = {};
  let number = 0;
  let submitted = false;
  const about = el("div", { class: "quiet about" });
  const fields = el("div", { class: "fields" });
  const text = el("textarea", {
    spellcheck: "false",
    rows: 24,
    "aria-label": form.json,
    oninput: () => typed(),
  });
  const wrong = el("p", { class: "faults", role: "alert" });
  const estimate = el("div", { class: "estimate", role: "status" });
  const elsewhere = el("div", { class: "faults" });
  const submit = el("button", { type: "submit", class: "primary" }, form.submit);

  /** @type {Held} */
  const held = {
    get document() {
      return document_;
    },
    get: (path) => at(document_, path),
    set: (path, value) => (put(document_, path.split("."), value), changed()),
    again: () => (draw(), changed()),
    put: (next) => ((document_ = next), draw(), changed()),
  };

  /** @param {string} name */
  function choose(name) {
    const start = /** @type {Start} */ (form.starts.find((one) => one.name === name));
    document_ = structuredClone(start.definition);
    submitted = false;
    fill(
      about,
      start.about.map((paragraph) => el("p", {}, prose(paragraph))),
    );
    draw();
    if (!start.empty) return changed();
    showFaults(fields, [], elsewhere);
    write();
    fill(estimate, "Fill in the fields. What is missing, and what it will take, is said here.");
  }

  /** Draw the fields anew; who changes them by keyboard goes on from there, not from the top of the page. */
  function draw() {
    const label = labelOf(document.activeElement);
    fill(fields, ...form.fields(held));
    const inputs = /** @type {HTMLInputElement[]} */ ([...fields.querySelectorAll("select, input")]);
    if (label) inputs.find((one) => labelOf(one) === label)?.focus();
  }

  function write() {
    text.value = JSON.stringify(document_, null, 2);
    wrong.textContent = "";
    submit.disabled = false;
  }

  function changed() {
    write();
    judge();
  }

  function typed() {
    const read = typedObject(text, wrong, submit);
    if (read === null) return;
    document_ = read;
    draw();
    judge();
  }

  const judge = debounced(300, async () => {
    // the question before is not given up, which would end the process that computes it
    const mine = ++number;
    try {
      const cost = await send(form.path, document_, { dry_run: true });
      if (mine !== number) return;
      showFaults(fields, [], elsewhere);
      fill(estimate, form.estimated(cost));
    } catch (error) {
      if (mine === number && error instanceof Refusal) refused(error);
    }
  });

  /** @param {Refusal} refusal */
  function refused(refusal) {
    const { wrong: faults, missing } = showFaults(fields, refusal.faults, elsewhere, submitted);
    const left = [
      missing && `${counted(missing, "field")} to fill in`,
      faults && `${counted(faults, "fault")} to fix`,
    ];
    const words = left.filter(Boolean).join(" and ");
    fill(estimate, words ? `${words} before it can ${form.can}.` : refusalBox(refusal));
  }

  /** @param {Event} event */
  async function run(event) {
    event.preventDefault();
    submit.disabled = submitted = true;
    try {
      form.waits?.();
      form.done(await send(form.path, document_));
      submit.disabled = false;
    } catch (error) {
      submit.disabled = false;
      if (error instanceof Refusal && error.faults.length) refused(error);
      else fill(elsewhere, refusalBox(error));
    }
  }

  const first = form.starts.some(({ name }) => name === form.first) ? form.first : form.starts[0].name;
  const options = /** @type {[string, string][]} */ (form.starts.map(({ name }) => [name, name]));
  fill(
    root,
    el("div", { class: "row spread" }, el("h1", {}, form.title), form.help),
    el("div", { class: "row" }, picker("Start from", options, first, choose)),
    about,
    el(
      "form",
      { class: "columns", onsubmit: run, novalidate: true },
      el("div", {}, fields),
      el(
        "div",
        { class: "beside" },
        form.beside,
        el("section", { class: "box cost", "aria-label": form.cost }, estimate, elsewhere, submit),
        el(
          "details",
          { open: window.matchMedia("(min-width: 60rem)").matches },
          el("summary", {}, form.json),
          el("p", { class: "quiet" }, "Edit it here or in the fields: each follows the other."),
          text,
          wrong,
        ),
      ),
    ),
  );
  choose(first);
  return () => void ++number;
}

/** What a field is called, with the group that it stands in. @param {Element | null} field */
function labelOf(field) {
  const labelled = field instanceof HTMLInputElement || field instanceof HTMLSelectElement;
  const own = labelled ? field.labels?.[0] : null;
  const name =
    field?.getAttribute("aria-label") ?? own?.querySelector("span")?.textContent ?? own?.textContent;
  return name && `${field?.closest("fieldset")?.querySelector("legend")?.textContent} ${name}`;
}

/** @param {any} document @param {string} path */
function at(document, path) {
  const step = (/** @type {any} */ held, /** @type {string} */ key) =>
    held !== null && typeof held === "object" ? held[key] : undefined;
  return path.split(".").reduce(step, document);
}

/**
 * Put a value at a path; undefined takes it away, with what is empty then.
 *
 * @param {any} held
 * @param {string[]} path
 * @param {any} value
 */
function put(held, [key, ...rest], value) {
  if (!rest.length) {
    if (value === undefined) delete held[key];
    else held[key] = value;
    return;
  }
  if (held[key] === null || typeof held[key] !== "object") {
    if (value === undefined) return;
    held[key] = {};
  }
  put(held[key], rest, value);
  if (key !== "choose" && !Array.isArray(held) && Object.keys(held[key]).length === 0) delete held[key];
}
