/** Requests that may have to wait for the compiler, and reports of the compiler's progress. */
/** @import { Answer, Readiness } from "./types.js" */

import { send } from "./api.js";
import { counted } from "./numbers.js";

const LOOK_MILLISECONDS = 1000;

/**
 * Request a computation. Until the answer arrives, report whether kernels are being compiled for the request.
 *
 * @template {string} Path
 * @param {Path} path
 * @param {unknown} document
 * @param {(words: string) => void} tell called with the progress of the compiler; the text is empty if
 *   nothing is compiled
 * @param {AbortSignal} [signal]
 * @param {Record<string, unknown>} [parameters]
 * @returns {Promise<Answer<Path>>}
 */
export async function sendPatiently(path, document, tell, signal = undefined, parameters = {}) {
  let waits = true;
  const look = async () => {
    if (!waits || signal?.aborted) return;
    try {
      const ready = /** @type {Readiness} */ (
        /** @type {unknown} */ (await send(path, document, { ...parameters, dry_run: true }, signal))
      );
      if (waits) tell(ready.phase === "compiling" ? compiling(ready) : "");
    } catch {
      return; // the fault is reported by the answer to the main request
    }
    if (waits) setTimeout(look, LOOK_MILLISECONDS);
  };
  const timer = setTimeout(look, LOOK_MILLISECONDS);
  try {
    return await send(path, document, parameters, signal);
  } finally {
    waits = false;
    clearTimeout(timer);
  }
}

/**
 * A sentence that says how many kernels have been compiled.
 *
 * @param {{phase_done: number | null, phase_total: number | null}} at numbers of compiled and of all scenes
 */
export function compiling(at) {
  return `Compiling kernels, ${at.phase_done} of ${counted(at.phase_total ?? 0, "scene")} done …`;
}
