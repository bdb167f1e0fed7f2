/** A request that may wait for the compiler; its progress is reported until the answer arrives. */
/** @import { Answer, Readiness } from "./types.js" */

import { send } from "./api.js";
import { counted } from "./numbers.js";

const LOOK_MILLISECONDS = 1000;

/**
 * Send a document to be computed, and report meanwhile whether kernels are being compiled for it.
 *
 * @template {string} Path
 * @param {Path} path
 * @param {unknown} document
 * @param {(words: string) => void} tell called with the progress of compiling; empty if nothing is compiled
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
      return; // the answer to the request itself reports the fault
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
 * A sentence that kernels are being compiled, and how many are done.
 *
 * @param {{phase_done: number | null, phase_total: number | null}} at how many of them
 */
export function compiling(at) {
  return `Compiling kernels, ${at.phase_done} of ${counted(at.phase_total ?? 0, "scene")} done …`;
}
