/** Shows the state and the progress of a study or a design, and the buttons to cancel, resume or delete. */
/** @import { Listed, StudyRecord } from "./types.js" */

import { ask, refusalBox } from "./api.js";
import { confirmed, el, fill, say, smallButton } from "./dom.js";
import { counted, count, duration, short } from "./numbers.js";
import { compiling } from "./patience.js";
import { WORDS } from "./words.js";

const SIGNS = /** @type {Record<string, string>} */ ({
  queued: "◷",
  running: "▶",
  done: "✓",
  cancelled: "◼",
  failed: "✕",
});

/** @param {string} state */
export function isActive(state) {
  return !WORDS.ended.includes(state);
}

/** A note if an earlier solver computed the results. @param {StudyRecord} record */
export function outdatedNote(record) {
  return (
    record.outdated &&
    el("p", { class: "quiet outdated" }, "Outdated: computed by an earlier version of the solver.")
  );
}

/** A state as a sign and a word, which can be read without colours. @param {string} state */
export function badge(state) {
  return el(
    "span",
    { class: `badge ${state}` },
    el("span", { "aria-hidden": "true" }, SIGNS[state] ?? "?", " "),
    state,
  );
}

/** The activity of a study before its first block, or an empty text. @param {StudyRecord} record */
function preparation(record) {
  if (record.phase === "starting") return "Starting workers …";
  if (record.phase === "waiting") return "Waiting for workers …";
  return record.phase === "compiling" ? compiling(record) : "";
}

/** The progress of a study, as a bar and in words. @param {StudyRecord} record */
export function progressBar(record) {
  const done = record.points_done;
  const total = record.points_total;
  const seconds = record.seconds_left ?? 0;
  const left =
    record.state === "running" && seconds > 0
      ? `, ${short((total - done) / seconds, 2)} points/s, ${duration(seconds)} left`
      : "";
  const failed = record.points_failed ? `, ${count(record.points_failed)} failed` : "";
  const before = preparation(record);
  const words = before
    ? before
    : done === total
      ? counted(total, "point") + failed
      : `${count(done)} of ${counted(total, "point")}${failed}${left}`;
  return el(
    "span",
    { class: "progress" },
    done < total &&
      el("progress", { max: total, value: done, "aria-label": `Progress of ${record.name || record.id}` }),
    el("span", { class: "words" }, words),
  );
}

/**
 * Buttons to cancel, resume and delete a study or a design, or to restore it from the trash.
 *
 * @template {Listed & {outdated?: boolean, points_done?: number}} T
 * @param {"studies" | "designs"} kind
 * @param {T} record
 * @param {(record: T | null) => void} onChange called with the new record, or null after a deletion
 * @param {boolean} [gone] whether the study or design is in the trash
 */
export function actions(kind, record, onChange, gone = false) {
  const place = el("span", { class: "row" });
  const name = record.name || record.id;
  const path = `${kind}/${encodeURIComponent(record.id)}`;
  const title = `Delete this ${kind === "studies" ? "study" : "design"}?`;
  const post = async (/** @type {string} */ verb) =>
    /** @type {T} */ (await ask(`${path}/${verb}`, {}, { method: "POST" }));
  /** @param {string} label @param {() => Promise<T | null | undefined>} act undefined if nothing changes */
  const steering = (label, act) => {
    const onclick = async () => {
      try {
        const changed = await act();
        if (changed === undefined) return;
        say(`${name}: ${changed ? changed.state : "deleted"}`);
        onChange(changed);
      } catch (error) {
        fill(place, refusalBox(error));
      }
    };
    return smallButton(label, onclick, `${label} ${name}`);
  };
  const remove = async () => {
    const points = record.points_done ? ` and its ${counted(record.points_done, "computed point")}` : "";
    const text = `“${name}”${points} can be restored from the trash for a week.`;
    if (!(await confirmed(title, text, "Delete it"))) return undefined;
    await ask(path, { trash: true }, { method: "DELETE" });
    return null;
  };
  const removeForGood = async () => {
    if (!(await confirmed(title, `“${name}” will be gone for good.`, "Delete it for good"))) return undefined;
    await post("undelete");
    await ask(path, {}, { method: "DELETE" });
    return null;
  };
  // the new version is another study, and the shown study is unchanged
  const recompute = async () => {
    location.hash = `#/studies/${(await post("recompute")).id}`;
    return undefined;
  };
  const active = isActive(record.state);
  const stopped = record.state === "cancelled" || record.state === "failed";
  fill(
    place,
    gone && [steering("Restore", () => post("undelete")), steering("Delete for good", removeForGood)],
    !gone && active && steering("Cancel", () => post("cancel")),
    !gone && stopped && steering("Resume", () => post("resume")),
    !gone && record.outdated && !active && steering("Recompute", recompute),
    !gone && !active && steering("Delete", remove),
  );
  return place;
}
