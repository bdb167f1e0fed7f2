/** Shows one study: its state, and tabs with its results. */
/** @import { Catalogue, StudyRecord, View } from "./types.js" */

import { address, ask, follow, Refusal, studyPath } from "./api.js";
import { besideTab } from "./beside.js";
import { catalogue } from "./catalogue.js";
import { comparisonTab } from "./comparison.js";
import { dampersTab } from "./dampers_tab.js";
import { earthquakeTab } from "./earthquake.js";
import { box, el, facts, fill, prose, quiet, say } from "./dom.js";
import { explorerTab } from "./explorer.js";
import { leading } from "./headline.js";
import { help } from "./help.js";
import { Kept, plainly } from "./kept.js";
import { mapTab } from "./map_tab.js";
import { count, duration, moment } from "./numbers.js";
import { actions, badge, isActive, outdatedNote, progressBar } from "./progress.js";
import { remarksForm } from "./remarks.js";
import { FREQUENCY, RECORD, Selection } from "./selection.js";
import { Shown, unitSwitch } from "./shown.js";
import { kindOf, vocabulary } from "./vocabulary.js";
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

/** Tabs of suites and of studies over base amplitudes. @type {[string, string, Tab][]} */
const DAMPER_TABS = [
  ["map", "Map and dampers", dampersTab],
  ["beside", "Compare", besideTab],
  ["data", "Data", dataTab],
];

/** @type {View} */
export async function studyView(root, { parts, query }) {
  const [id, tab = "map"] = parts;
  const session = await sessionOf(id, tab, query);
  const view = new StudyView(session);
  const place = el("div", { class: "tab" });
  fill(root, view.head, tabList(tab, place, session), place);
  session.selection.addEventListener("chosen", () => keepPoint(session));
  return () => view.stop?.();
}

/**
 * A study and its selected point. If the address gives no point, the best design is selected.
 *
 * @param {string} id
 * @param {string} tab
 * @param {URLSearchParams} query
 * @returns {Promise<Session>}
 */
async function sessionOf(id, tab, query) {
  const [record, words, grid] = await Promise.all([
    ask(studyPath(id)),
    vocabulary(),
    ask(studyPath(id, "axes")),
  ]);
  const selection = new Selection(grid.axes);
  const kept = new Kept(`#/studies/${record.id}/${tab}`, query);
  if (selection.worst) selection.worst = kept.on("worst", true);
  /** @type {Record<string, number | string>} */
  const asked = {};
  for (const [name, text] of query) {
    const value = name === RECORD ? text : Number(text);
    if (name in grid.axes && (name === RECORD || Number.isFinite(value))) asked[name] = value;
  }
  if (Object.keys(asked).length) selection.chooseValues(asked);
  else await restAtBest(record, selection);
  return {
    record,
    selection,
    variables: grid.variables,
    words,
    changes: new EventTarget(),
    shown: new Shown(grid.in_units),
    renamed: () => undefined,
    kept,
  };
}

/** The head of a study, which shows the progress until the study has ended. */
class StudyView {
  title = el("h1");
  steering = el("span", { class: "row" });
  state = el("div");
  /** The state of the study for which the buttons were made. */
  steered = "";
  /** @type {(() => void) | undefined} */
  stop;

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    const { record, shown } = session;
    this.title.textContent = record.name || record.id;
    session.renamed = (name) => this.rename(name);
    const copy = `#/new?${new URLSearchParams({ from: record.id })}`;
    const buttons = [
      unitSwitch(shown, () => window.dispatchEvent(new Event("hashchange"))),
      el("a", { class: "button small", href: copy }, "Edit a copy"),
      this.steering,
    ];
    // an element with the keyboard focus is not replaced while the study runs
    this.head = el(
      "div",
      { class: "head" },
      el("div", { class: "row spread" }, this.title, el("div", { class: "row" }, buttons)),
      this.state,
    );
    this.drawHead();
    if (isActive(record.state)) this.listen();
  }

  /** @param {string} name */
  rename(name) {
    this.session.record.name = name;
    this.title.textContent = name || this.session.record.id;
    document.title = `${this.title.textContent} · damperlab`;
  }

  drawHead() {
    const now = this.session.record;
    if (this.steered !== `${now.state} ${now.outdated}`) this.steer(now);
    fill(
      this.state,
      el("div", { class: "row" }, badge(now.state), progressBar(now)),
      outdatedNote(now),
      now.message && el("p", { class: isActive(now.state) ? "box" : "box fault" }, prose(now.message)),
    );
  }

  /** Make the buttons for the state of the study, and keep the keyboard focus. @param {StudyRecord} now */
  steer(now) {
    const { steering, title } = this;
    const held = steering.contains(document.activeElement);
    this.steered = `${now.state} ${now.outdated}`;
    fill(
      steering,
      actions("studies", now, (changed) => {
        if (changed === null) location.hash = "#/";
        else this.update(changed);
      }),
    );
    if (!held) return;
    title.setAttribute("tabindex", "-1");
    title.focus({ preventScroll: true });
  }

  /** @param {StudyRecord} changed */
  update(changed) {
    const { session } = this;
    const before = session.record;
    const grown = changed.blocks_done !== before.blocks_done || changed.state !== before.state;
    session.record = { ...before, ...changed };
    this.drawHead();
    if (grown) session.changes.dispatchEvent(new Event("grown"));
    if (isActive(session.record.state)) this.listen();
  }

  listen() {
    const { id } = this.session.record;
    this.stop ??= follow(id, (changed, event) => {
      if (event !== "progress") this.stop = undefined;
      if (event === "deleted") location.hash = "#/";
      else this.update(changed);
      if (event === "end") say(`${this.session.record.name || id} is ${changed.state}.`);
    });
  }
}

/** @param {StudyRecord} record @param {Selection} selection */
async function restAtBest(record, selection) {
  try {
    const { best } = leading(await ask(studyPath(record.id, "optimal-designs"), { top: 1 }));
    if (best) selection.rest(best);
  } catch (error) {
    // Nothing is computed yet, or the study stores no amplitude. Then the point is not moved.
    if (!(error instanceof Refusal)) throw error;
  }
}

/** Keep the point in the address, so that a link leads to the point. @param {Session} session */
function keepPoint({ selection, kept }) {
  if (!selection.chosen) return;
  const point = selection.varied.map((name) => [name, plainly(selection.axes[name], selection.place[name])]);
  const band = (selection.axes[FREQUENCY] ?? []).length > 1;
  kept.keep({ ...Object.fromEntries(point), worst: band && !selection.worst ? false : null });
}

/**
 * Links to the tabs of a study, followed by the content of the current tab.
 *
 * @param {string} current
 * @param {HTMLElement} place
 * @param {Session} session
 */
function tabList(current, place, session) {
  const { id, dimensions } = session.record;
  const tabs = kindOf(dimensions) === "harmonic" ? TABS : DAMPER_TABS;
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
function dataTab({ record, renamed }, place) {
  const definition = JSON.stringify(record.definition, null, 2);
  const looks = { tabindex: 0, role: "region", "aria-label": "Definition as JSON" };
  fill(
    place,
    el(
      "div",
      { class: "columns" },
      el(
        "section",
        { class: "box" },
        help("reference/client/", "results in Python"),
        downloads(record.id),
        report(record.id),
        el("h2", {}, "The study"),
        about(record),
        el("h2", {}, "What it answers"),
        catalogue(record),
        el("h2", {}, "Name, tags and note"),
        remarksForm(record, renamed),
      ),
      box("Definition", el("pre", looks, definition)),
    ),
  );
}

/** @param {string} id */
function downloads(id) {
  const links = Object.entries(WORDS.export_formats).map(([format, text]) => {
    const { href } = address(studyPath(id, "export"), { format });
    return el("li", {}, el("a", { href, download: true }, text));
  });
  return [
    el("h2", {}, "Download the data"),
    el("ul", {}, links),
    quiet(
      "Points not computed yet have status −1. Other programs can read the cube in place, as Zarr: ",
      el("code", {}, address(studyPath(id, "zarr/")).href),
    ),
  ];
}

/** @param {string} id */
function report(id) {
  const { href } = address(studyPath(id, "report"));
  return [
    el("h2", {}, "Report"),
    el(
      "p",
      {},
      el("a", { class: "button", href, target: "_blank", rel: "noopener" }, "Open the report"),
      " Maps, designs, a comparison with a tuned mass damper, accuracy and versions on one page, to keep " +
        "or to print.",
    ),
  ];
}

/** @param {StudyRecord} record */
function about(record) {
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
  return facts(entries);
}
