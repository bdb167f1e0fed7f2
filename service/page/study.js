/** One study: its state, and what can be asked of it, in tabs. */
/** @import { Catalogue, StudyRecord, View } from "./types.js" */

import { address, ask, follow, Refusal, studyPath } from "./api.js";
import { besideTab } from "./beside.js";
import { catalogue } from "./catalogue.js";
import { comparisonTab } from "./comparison.js";
import { dampersTab } from "./dampers_tab.js";
import { earthquakeTab } from "./earthquake.js";
import { el, fill, prose, say } from "./dom.js";
import { explorerTab } from "./explorer.js";
import { leading } from "./headline.js";
import { help } from "./help.js";
import { Kept, plainly } from "./kept.js";
import { mapTab } from "./map_tab.js";
import { count, duration, moment } from "./numbers.js";
import { actions, badge, isActive, outdatedNote, progressBar } from "./progress.js";
import { remarksForm } from "./remarks.js";
import { AMPLITUDE, FREQUENCY, RECORD, Selection } from "./selection.js";
import { Shown, unitSwitch } from "./shown.js";
import { vocabulary } from "./vocabulary.js";
import { WORDS } from "./words.js";

/**
 * @typedef {{record: StudyRecord, selection: Selection, variables: string[],
 *   words: Catalogue, changes: EventTarget, kept: Kept, shown: Shown,
 *   renamed: (name: string) => void}} Session
 * @typedef {(session: Session, place: HTMLElement) => void | Promise<void>} Tab
 */

/** @type {[string, string, Tab][]} */
const TABS = [
  ["map", "Map and point", mapTab],
  ["explore", "Explore", explorerTab],
  ["tmd", "Tuned mass damper", comparisonTab],
  ["earthquake", "Earthquake", earthquakeTab],
  ["beside", "Compare", besideTab],
  ["data", "Data", dataTab],
];

/** What can be asked of dampers that are judged by their worst case. @type {[string, string, Tab][]} */
const DAMPER_TABS = [
  ["map", "Map and dampers", dampersTab],
  ["beside", "Compare", besideTab],
  ["data", "Data", dataTab],
];

/** @type {View} */
export async function studyView(root, { parts, query }) {
  const record = await ask(studyPath(parts[0]));
  const [words, grid] = await Promise.all([vocabulary(), ask(studyPath(record.id, "axes"))]);
  /** @type {Session} */
  const session = {
    record,
    selection: new Selection(grid.axes),
    variables: grid.variables,
    words,
    changes: new EventTarget(),
    shown: new Shown(record.definition),
    renamed: () => undefined,
    kept: new Kept(`#/studies/${record.id}/${parts[1] ?? "map"}`, query),
  };
  if (session.selection.worst) session.selection.worst = session.kept.on("worst", true);
  /** @type {Record<string, number | string>} */
  const asked = {};
  for (const [name, text] of query) {
    const value = name === RECORD ? text : Number(text);
    if (name in grid.axes && (name === RECORD || Number.isFinite(value))) asked[name] = value;
  }
  if (Object.keys(asked).length) session.selection.chooseValues(asked);
  else await restAtBest(session);

  const title = el("h1", {}, record.name || record.id);
  const steering = el("span", { class: "row" });
  const state = el("div", {});
  // what holds the keyboard stays as it is while the study goes on
  const head = el(
    "div",
    { class: "head" },
    el(
      "div",
      { class: "row spread" },
      title,
      el(
        "div",
        { class: "row" },
        unitSwitch(session.shown, () => window.dispatchEvent(new Event("hashchange"))),
        el(
          "a",
          { class: "button small", href: `#/new?${new URLSearchParams({ from: record.id })}` },
          "Edit a copy",
        ),
        steering,
      ),
    ),
    state,
  );
  session.renamed = (name) => {
    session.record.name = name;
    title.textContent = name || record.id;
    document.title = `${title.textContent} · damperlab`;
  };
  let steered = "";
  const place = el("div", { class: "tab" });
  /** @type {(() => void) | undefined} */
  let stop;

  function drawHead() {
    const now = session.record;
    if (steered !== `${now.state} ${now.outdated}`) steer(now);
    fill(
      state,
      el("div", { class: "row" }, badge(now.state), progressBar(now)),
      outdatedNote(now),
      now.message && el("p", { class: isActive(now.state) ? "box" : "box fault" }, prose(now.message)),
    );
  }

  /**
   * What can be done with the study in its state; where a button that was held is gone, the title holds the
   * keyboard.
   *
   * @param {StudyRecord} now
   */
  function steer(now) {
    const held = steering.contains(document.activeElement);
    steered = `${now.state} ${now.outdated}`;
    fill(
      steering,
      actions("studies", now, (changed) => {
        if (changed === null) location.hash = "#/";
        else update(changed);
      }),
    );
    if (!held) return;
    title.setAttribute("tabindex", "-1");
    title.focus({ preventScroll: true });
  }

  /** @param {StudyRecord} changed */
  function update(changed) {
    const before = session.record;
    const grown = changed.blocks_done !== before.blocks_done || changed.state !== before.state;
    session.record = { ...session.record, ...changed };
    drawHead();
    if (grown) session.changes.dispatchEvent(new Event("grown"));
    if (isActive(session.record.state)) listen();
  }

  function listen() {
    stop ??= follow(session.record.id, (changed, event) => {
      if (event !== "progress") stop = undefined;
      if (event === "deleted") location.hash = "#/";
      else update(changed);
      if (event === "end") say(`${session.record.name || session.record.id} is ${changed.state}.`);
    });
  }

  drawHead();
  if (isActive(record.state)) listen();
  fill(root, head, tabList(record.id, parts[1] ?? "map", place, session), place);
  session.selection.addEventListener("chosen", () => keepPoint(session));
  return () => stop?.();
}

/** @param {Session} session */
async function restAtBest({ record, selection }) {
  try {
    const { best } = leading(await ask(studyPath(record.id, "optimal-designs"), { top: 1 }));
    if (best) selection.rest(best);
  } catch (error) {
    // Nothing is computed yet, or the study keeps no amplitude: any point will do.
    if (!(error instanceof Refusal)) throw error;
  }
}

/** Keep the point in the address, so that a link leads back to it. @param {Session} session */
function keepPoint({ selection, kept }) {
  if (!selection.chosen) return;
  const point = selection.varied.map((name) => [name, plainly(selection.axes[name], selection.place[name])]);
  const band = (selection.axes[FREQUENCY] ?? []).length > 1;
  kept.keep({ ...Object.fromEntries(point), worst: band && !selection.worst ? false : null });
}

/**
 * Links to the tabs, and the one that is shown.
 *
 * @param {string} id
 * @param {string} current
 * @param {HTMLElement} place
 * @param {Session} session
 */
function tabList(id, current, place, session) {
  const tabs = RECORD in session.selection.axes || AMPLITUDE in session.selection.axes ? DAMPER_TABS : TABS;
  const [shown, , show] = tabs.find(([name]) => name === current) ?? tabs[0];
  queueMicrotask(() => show(session, place));
  return el(
    "nav",
    { class: "tabs", "aria-label": "Parts of the study" },
    tabs.map(([name, title]) =>
      el(
        "a",
        {
          href: `#/studies/${id}/${name}`,
          "aria-current": name === shown ? "page" : null,
          onclick: (/** @type {Event} */ event) => {
            event.preventDefault();
            location.hash = session.kept.at(`#/studies/${id}/${name}`);
          },
        },
        title,
      ),
    ),
  );
}

/** @type {Tab} */
function dataTab(session, place) {
  const { record } = session;
  fill(
    place,
    el(
      "div",
      { class: "columns" },
      el(
        "section",
        { class: "box" },
        help("reference/client/", "results in Python"),
        el("h2", {}, "Download the data"),
        el(
          "ul",
          {},
          Object.entries(WORDS.export_formats).map(([format, text]) =>
            el(
              "li",
              {},
              el(
                "a",
                { href: address(studyPath(record.id, "export"), { format }).href, download: true },
                text,
              ),
            ),
          ),
        ),
        el(
          "p",
          { class: "quiet" },
          "Points not computed yet have status −1. Other programs can read the cube in place, as Zarr: ",
          el("code", {}, address(studyPath(record.id, "zarr/")).href),
        ),
        el("h2", {}, "Report"),
        el(
          "p",
          {},
          el(
            "a",
            {
              class: "button",
              href: address(studyPath(record.id, "report")).href,
              target: "_blank",
              rel: "noopener",
            },
            "Open the report",
          ),
          " Maps, designs, a tuned mass damper beside them, accuracy and versions on one page, to keep " +
            "or to print.",
        ),
        el("h2", {}, "The study"),
        facts(record),
        el("h2", {}, "What it answers"),
        catalogue(record),
        el("h2", {}, "Name, tags and note"),
        remarksForm(record, session.renamed),
      ),
      el(
        "section",
        { class: "box" },
        el("h2", {}, "Definition"),
        el(
          "pre",
          { tabindex: 0, role: "region", "aria-label": "Definition as JSON" },
          JSON.stringify(record.definition, null, 2),
        ),
      ),
    ),
  );
}

/** @param {StudyRecord} record */
function facts(record) {
  const entries = /** @type {[string, string][]} */ ([
    ["Id", record.id],
    [
      "Points",
      `${count(record.points_done)} of ${count(record.points_total)}, ${count(record.points_failed)} failed`,
    ],
    ["Reused from earlier studies", count(record.points_reused)],
    .../** @type {[string, string][]} */ (record.priority ? [["Priority", String(record.priority)]] : []),
    ["Submitted", moment(record.created) + (record.submitted_by ? ` by ${record.submitted_by}` : "")],
    ["Finished", moment(record.finished)],
    ["Time in kernels", duration(record.kernel_seconds)],
    ["Version", record.provenance?.solver_version ?? "–"],
  ]);
  return el(
    "dl",
    { class: "facts" },
    entries.map(([term, value]) => el("div", {}, el("dt", {}, term), el("dd", {}, value))),
  );
}
