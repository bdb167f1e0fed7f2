/** A form for one document, which can be edited in fields or as JSON and which the service checks. */
/** @import { Child } from "./types.js" */

import { Refusal, refusalBox, send } from "./api.js";
import { debounced, el, fill, heading, picker, prose, quiet, typedObject } from "./dom.js";
import { showFaults } from "./faults.js";
import { counted } from "./numbers.js";

/**
 * @typedef {{name: string, about: string[], definition: object, empty?: boolean}} Start a document with which
 *   a form may begin
 * @typedef {{document: unknown, get: <T>(path: string) => T | undefined, set: (path: string, value: unknown)
 * => void, again: () => void, put: (document: unknown) => void}} Held access to the document by the paths
 * of fields. `set` with undefined removes a field, `again` draws all fields, `put` replaces the document
 */
/**
 * @template Cost, Answer
 * @typedef {{title: string, help: HTMLElement | false, json: string, path: string, submit: string, cost:
 *   string, can: string, starts: Start[], first: string, beside?: HTMLElement, fields: (held: Held) =>
 *   Child[], estimated: (cost: Cost) => Child, waits?: () => void, done: (answer: Answer) => void}} Form
 *   `waits` is called when the form is submitted, and `done` is called with the answer
 */

/**
 * @template Cost, Answer
 * @param {HTMLElement} root
 * @param {Form<Cost, Answer>} form
 * @returns {() => void} a function that leaves the form
 */
export function documentForm(root, form) {
  const drawn = new DocumentForm(form);
  drawn.drawIn(root);
  return () => drawn.leave();
}

/** @template Cost, Answer */
class DocumentForm {
  /** @type {unknown} */
  document = {};
  /** Number of the last request that checks the document. */
  number = 0;
  submitted = false;
  about = el("div", { class: "quiet about" });
  fields = el("div", { class: "fields" });
  wrong = el("p", { class: "faults", role: "alert" });
  estimate = el("div", { class: "estimate", role: "status" });
  elsewhere = el("div", { class: "faults" });

  /** @param {Form<Cost, Answer>} form */
  constructor(form) {
    this.form = form;
    const oninput = () => this.typed();
    this.text = el("textarea", { spellcheck: "false", rows: 24, "aria-label": form.json, oninput });
    this.submit = el("button", { type: "submit", class: "primary" }, form.submit);
    this.judge = debounced(300, () => this.askForCost());
  }

  /** @param {HTMLElement} root */
  drawIn(root) {
    const { title, help, starts, beside, cost, json, first: wanted } = this.form;
    const first = starts.some(({ name }) => name === wanted) ? wanted : starts[0].name;
    const options = /** @type {[string, string][]} */ (starts.map(({ name }) => [name, name]));
    const onsubmit = (/** @type {Event} */ event) => (event.preventDefault(), void this.run());
    const wide = window.matchMedia("(min-width: 60rem)").matches;
    fill(
      root,
      heading(title, help),
      el(
        "div",
        { class: "row" },
        picker("Start from", options, first, (name) => this.begin(name)),
      ),
      this.about,
      el(
        "form",
        { class: "columns", onsubmit, novalidate: true },
        el("div", {}, this.fields),
        el(
          "div",
          { class: "beside" },
          beside,
          el(
            "section",
            { class: "box cost", "aria-label": cost },
            this.estimate,
            this.elsewhere,
            this.submit,
          ),
          el(
            "details",
            { open: wide },
            el("summary", {}, json),
            quiet("Edit it here or in the fields; both stay equal."),
            this.text,
            this.wrong,
          ),
        ),
      ),
    );
    this.begin(first);
  }

  /** Leave the form, and ignore the answers to earlier requests. */
  leave() {
    this.number += 1;
  }

  /** @param {string} name of the document with which the form begins */
  begin(name) {
    const start = /** @type {Start} */ (this.form.starts.find((one) => one.name === name));
    this.document = structuredClone(start.definition);
    this.submitted = false;
    fill(
      this.about,
      start.about.map((paragraph) => el("p", {}, prose(paragraph))),
    );
    this.draw();
    if (!start.empty) return this.changed();
    showFaults(this.fields, [], this.elsewhere);
    this.write();
    fill(this.estimate, "Fill in the fields. Missing values and the expected cost are shown here.");
  }

  /** Draw all fields again. The field that had the keyboard focus gets the focus again. */
  draw() {
    const label = labelOf(document.activeElement);
    fill(this.fields, ...this.form.fields(this.held()));
    const inputs = /** @type {HTMLInputElement[]} */ ([...this.fields.querySelectorAll("select, input")]);
    if (label) inputs.find((one) => labelOf(one) === label)?.focus();
  }

  /** @returns {Held} */
  held() {
    const again = () => (this.draw(), this.changed());
    return {
      document: this.document,
      get: (path) => at(this.document, path),
      set: (path, value) => (put(this.document, path.split("."), value), this.changed()),
      again,
      put: (next) => ((this.document = next), again()),
    };
  }

  write() {
    this.text.value = JSON.stringify(this.document, null, 2);
    this.wrong.textContent = "";
    this.submit.disabled = false;
  }

  changed() {
    this.write();
    this.judge();
  }

  typed() {
    const read = typedObject(this.text, this.wrong, this.submit);
    if (read === null) return;
    this.document = read;
    this.draw();
    this.judge();
  }

  async askForCost() {
    // the earlier request is not aborted, because the service would end the process that computes the answer
    const mine = ++this.number;
    try {
      const cost = await send(this.form.path, this.document, { dry_run: true });
      if (mine !== this.number) return;
      showFaults(this.fields, [], this.elsewhere);
      fill(this.estimate, this.form.estimated(/** @type {Cost} */ (cost)));
    } catch (error) {
      if (mine === this.number && error instanceof Refusal) this.refused(error);
    }
  }

  /** @param {Refusal} refusal */
  refused(refusal) {
    const { wrong, missing } = showFaults(this.fields, refusal.faults, this.elsewhere, this.submitted);
    const left = [
      missing && `${counted(missing, "field")} to fill in`,
      wrong && `${counted(wrong, "fault")} to fix`,
    ];
    const words = left.filter(Boolean).join(" and ");
    fill(this.estimate, words ? `${words} before it can ${this.form.can}.` : refusalBox(refusal));
  }

  async run() {
    this.submit.disabled = this.submitted = true;
    try {
      this.form.waits?.();
      const { name } = /** @type {{name?: unknown}} */ (this.document);
      const stored = /** @type {Answer} */ (await send(this.form.path, this.document));
      const already = storedAlready(this.form.path, /** @type {Stored} */ (stored), name);
      if (already) fill(this.elsewhere, already);
      else this.form.done(stored);
    } catch (error) {
      if (error instanceof Refusal && error.faults.length) this.refused(error);
      else fill(this.elsewhere, refusalBox(error));
    } finally {
      this.submit.disabled = false;
    }
  }
}

/** @typedef {{id: string, name: string}} Stored */

/**
 * The message that the same content is stored under another name; null if both names are equal.
 *
 * @param {string} path of the list of such items
 * @param {Stored} stored
 * @param {unknown} name that was requested
 */
function storedAlready(path, stored, name) {
  if (!isStoredAlready(stored.name, name)) return null;
  const was = stored.name ? `under the name “${stored.name}”` : "without a name";
  return [
    `The same content is stored already ${was}, so the name “${name}” was not taken. `,
    el("a", { href: `#/${path}/${stored.id}` }, "Open it"),
  ];
}

/** Whether a requested name differs from the stored name. @param {string} stored @param {unknown} name */
export function isStoredAlready(stored, name) {
  return typeof name === "string" && name.trim() !== "" && name.trim() !== stored.trim();
}

/** The name of a field, with its group. @param {Element | null} field */
function labelOf(field) {
  const labelled = field instanceof HTMLInputElement || field instanceof HTMLSelectElement;
  const own = labelled ? field.labels?.[0] : null;
  const name =
    field?.getAttribute("aria-label") ?? own?.querySelector("span")?.textContent ?? own?.textContent;
  return name && `${field?.closest("fieldset")?.querySelector("legend")?.textContent} ${name}`;
}

/** @typedef {Record<string, unknown>} Branch an object of a document, or a list with indices as keys */

/** @param {unknown} value @returns {value is Branch} */
function isBranch(value) {
  return value !== null && typeof value === "object";
}

/** @template T @param {unknown} document @param {string} path @returns {T | undefined} */
function at(document, path) {
  const step = (/** @type {unknown} */ held, /** @type {string} */ key) =>
    isBranch(held) ? held[key] : undefined;
  return /** @type {T | undefined} */ (path.split(".").reduce(step, document));
}

/**
 * Set the value at a path. If the new value is undefined, remove the entry, and remove objects that are
 * then empty.
 *
 * @param {unknown} held
 * @param {string[]} path
 * @param {unknown} value
 */
function put(held, [key, ...rest], value) {
  const branch = /** @type {Branch} */ (held);
  if (!rest.length) {
    if (value === undefined) delete branch[key];
    else branch[key] = value;
    return;
  }
  if (!isBranch(branch[key])) {
    if (value === undefined) return;
    branch[key] = {};
  }
  const inner = /** @type {Branch} */ (branch[key]);
  put(inner, rest, value);
  if (key !== "choose" && !Array.isArray(branch) && Object.keys(inner).length === 0) delete branch[key];
}
