/** A study's state: its badge, its progress, and what can be done with it. */

import { ask, refusalBox, studyPath } from "./api.js";
import { confirmed, el, fill, say } from "./dom.js";
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

/** What is said of results of an earlier solver. @param {import("./answers.js").StudyRecord} record */
export function outdatedNote(record) {
  return (
    record.outdated &&
    el("p", { class: "quiet outdated" }, "Outdated: computed by an earlier version of the solver.")
  );
}

/** A state as a sign and a word: never by colour alone. @param {string} state */
export function badge(state) {
  return el(
    "span",
    { class: `badge ${state}` },
    el("span", { "aria-hidden": "true" }, SIGNS[state] ?? "?", " "),
    state,
  );
}

/**
 * What a study does before its first block; empty where it is beyond that.
 *
 * @param {import("./answers.js").StudyRecord} record
 */
function preparation(record) {
  if (record.phase === "starting") return "Starting workers …";
  if (record.phase === "waiting") return "Waiting for workers …";
  return record.phase === "compiling" ? compiling(record) : "";
}

/** How far a study is, as a bar and in words. @param {import("./answers.js").StudyRecord} record */
export function progressBar(record) {
  const done = record.points_done;
  const total = record.points_total;
  const left =
    record.state === "running" && record.seconds_left > 0
      ? `, ${short((total - done) / record.seconds_left, 2)} points/s, ${duration(record.seconds_left)} left`
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
 * Buttons to cancel, resume and delete a study, or to restore it from the trash.
 *
 * @param {import("./answers.js").StudyRecord} record
 * @param {(record: unknown) => void} onChange told the new record, null where the study is gone
 * @param {boolean} [gone] whether it is in the trash
 */
export function actions(record, onChange, gone = false) {
  const place = el("span", { class: "row" });
  const name = record.name || record.id;
  /** @param {string} label @param {() => Promise<any>} act */
  const button = (label, act) =>
    el(
      "button",
      {
        type: "button",
        class: "small",
        "aria-label": `${label} ${name}`,
        onclick: async () => {
          try {
            const changed = await act();
            if (changed === undefined) return;
            say(`${name}: ${changed ? changed.state : "deleted"}`);
            onChange(changed);
          } catch (error) {
            fill(place, refusalBox(error));
          }
        },
      },
      label,
    );
  /** @param {string} verb */
  const post = (verb) => ask(studyPath(record.id, verb), {}, { method: "POST" });
  const remove = async () => {
    const text =
      `“${name}” and its ${counted(record.points_done, "computed point")} can be restored from the trash ` +
      "for a week.";
    if (!(await confirmed("Delete this study?", text, "Delete it"))) return undefined;
    return ask(studyPath(record.id), { trash: true }, { method: "DELETE" });
  };
  const removeForGood = async () => {
    const text = `“${name}” will be gone for good.`;
    if (!(await confirmed("Delete this study?", text, "Delete it for good"))) return undefined;
    await post("undelete");
    return ask(studyPath(record.id), {}, { method: "DELETE" });
  };
  // the new version is another study: nothing about this one has changed
  const recompute = async () => {
    location.hash = `#/studies/${(await post("recompute")).id}`;
    return undefined;
  };
  const active = isActive(record.state);
  const stopped = record.state === "cancelled" || record.state === "failed";
  fill(
    place,
    gone && button("Restore", () => post("undelete")),
    gone && button("Delete for good", removeForGood),
    !gone && active && button("Cancel", () => post("cancel")),
    !gone && stopped && button("Resume", () => post("resume")),
    !gone && record.outdated && !active && button("Recompute", recompute),
    !gone && !active && button("Delete", remove),
  );
  return place;
}
