/**
 * Requests of this page to the service. Every refusal becomes a `Refusal`, which holds the problem document.
 *
 * @typedef {{field: string, found: string, allowed: string, advice: string, message: string}} Fault
 */
/** @import { Answer, Child, StudyRecord } from "./types.js" */

import { capital, el, prose } from "./dom.js";

/** Name of the event after which the page asks for a key. */
export const KEY_NEEDED = "key-needed";

const ROOT = new URL("api/v1/", document.baseURI);

/** A request that the service refused or did not answer. */
export class Refusal extends Error {
  /** @param {number} status @param {string} detail @param {Fault[]} faults */
  constructor(status, detail, faults) {
    super(detail);
    this.status = status;
    this.faults = faults;
  }
}

/**
 * An address with parameters. Parameters that are null or undefined are left out.
 *
 * @param {string} path
 * @param {Record<string, unknown>} [parameters]
 */
export function address(path, parameters = {}) {
  const url = new URL(path, ROOT);
  for (const [name, value] of Object.entries(parameters)) {
    if (value !== null && value !== undefined && value !== "") url.searchParams.set(name, String(value));
  }
  return url;
}

/**
 * Request a document.
 *
 * @template {string} Path
 * @param {Path} path
 * @param {Record<string, unknown>} [parameters]
 * @param {RequestInit} [options]
 * @returns {Promise<Answer<Path>>}
 */
export async function ask(path, parameters = {}, options = {}) {
  let answer;
  try {
    answer = await fetch(address(path, parameters), options);
  } catch (error) {
    if (options.signal?.aborted) throw error;
    throw new Refusal(0, "The service does not answer. Is it still running?", []);
  }
  if (answer.status === 204) return /** @type {Answer<Path>} */ (null);
  if (answer.status === 401 && path !== "session") window.dispatchEvent(new Event(KEY_NEEDED));
  const text = await answer.text();
  const document = parsed(text);
  if (!answer.ok)
    throw new Refusal(answer.status, document?.detail ?? answer.statusText, document?.errors ?? []);
  return document;
}

/** @param {string} text */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}

/**
 * Send a document.
 *
 * @template {string} Path
 * @param {Path} path
 * @param {unknown} document an object, or a text in JSON
 * @param {Record<string, unknown>} [parameters]
 * @param {AbortSignal} [signal]
 * @returns {Promise<Answer<Path>>}
 */
export function send(path, document, parameters = {}, signal = undefined) {
  const body = typeof document === "string" ? document : JSON.stringify(document);
  return ask(path, parameters, {
    method: "POST",
    body,
    headers: { "Content-Type": "application/json" },
    signal,
  });
}

/**
 * The path of a study, or of a question to it.
 *
 * @template {string} [Question=""]
 * @param {string} id
 * @param {Question} [question]
 * @returns {Question extends "" ? `studies/${string}` : `studies/${string}/${Question}`}
 */
export function studyPath(id, question) {
  const path = /** @type {const} */ (`studies/${encodeURIComponent(id)}`);
  return /** @type {ReturnType<typeof studyPath<Question>>} */ (question ? `${path}/${question}` : path);
}

/** The path of a design. @param {string} id @returns {`designs/${string}`} */
export function designPath(id) {
  return `designs/${encodeURIComponent(id)}`;
}

/**
 * Follow the progress of a study until the study has ended.
 *
 * @param {string} id
 * @param {(record: StudyRecord, state: "progress" | "end" | "deleted") => void}
 *   onEvent
 * @returns {() => void} stops following
 */
export function follow(id, onEvent) {
  const source = new EventSource(address(studyPath(id, "events")));
  source.addEventListener("progress", (event) => onEvent(JSON.parse(event.data), "progress"));
  for (const last of /** @type {const} */ (["end", "deleted"])) {
    source.addEventListener(last, (event) => {
      source.close();
      onEvent(JSON.parse(event.data), last);
    });
  }
  return () => source.close();
}

/**
 * An element with the message of a refusal, followed by each fault and its advice.
 *
 * @param {unknown} error
 * @returns {HTMLElement}
 */
export function refusalBox(error) {
  const faults = error instanceof Refusal ? error.faults : [];
  const title = error instanceof Refusal ? error.message : `Something failed on this page: ${error}`;
  return el(
    "div",
    { class: "box fault", role: "alert" },
    el("p", {}, title),
    faults.length > 0 &&
      el(
        "ul",
        {},
        faults.map((fault) => el("li", {}, faultText(fault))),
      ),
  );
}

/** The message of a fault, followed by the advice. @param {Fault} fault @returns {Child[]} */
export function faultText({ message, advice }) {
  return prose(sentences(message, advice));
}

/** @param {string} message @param {string} advice */
export function sentences(message, advice) {
  return `${message} ${capital(advice)}${advice && !/[.?!]$/.test(advice) ? "." : ""}`.trim();
}
