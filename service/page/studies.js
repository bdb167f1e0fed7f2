/** The list of studies: live, searchable, and helpful where there is none yet. */

import { ask, follow, refusalBox } from "./api.js";
import { el, fill, prose } from "./dom.js";
import { Kept } from "./kept.js";
import { moment } from "./numbers.js";
import { actions, badge, isActive, outdatedNote, progressBar } from "./progress.js";
import { tagList } from "./remarks.js";
import { studyFilter } from "./study_filter.js";
import { thumbnail } from "./thumbnail.js";
import { vocabulary } from "./vocabulary.js";

/**
 * Streams at once: a browser keeps six connections to a host, and the rest of the page needs some of them.
 */
const STREAMS = 2;
const LOOK_MILLISECONDS = 4000;
const PAGE = 50;

/** @type {import("./main.js").View} */
export async function studiesView(root, { query }) {
  const list = el("div", { class: "studies" });
  /** @type {Map<string, () => void>} */
  const streams = new Map();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  let left = false;
  let asked = 0;

  const filter = studyFilter(new Kept("#/", query), () => look());
  fill(
    root,
    el(
      "div",
      { class: "row spread" },
      el("h1", {}, "Studies"),
      el("a", { class: "button primary", href: "#/new" }, "New study"),
    ),
    filter.element,
    list,
  );

  /** @param {string} [cursor] */
  async function look(cursor) {
    clearTimeout(timer);
    const mine = ++asked;
    const nothing = filter.nothing();
    if (nothing) return fill(list, el("p", { class: "box" }, nothing));
    let page;
    try {
      page = await ask("studies", { ...filter.wanted(), limit: PAGE, cursor });
    } catch (error) {
      if (mine === asked) fill(list, refusalBox(error));
      return;
    }
    if (left || mine !== asked) return;
    if (page.studies.length === 0 && !cursor && !page.cursor)
      fill(list, filter.any() ? nothingFound() : await nothingYet());
    else draw(page, Boolean(cursor));
    listen(page.studies);
  }

  /** @param {any} page @param {boolean} more */
  function draw(page, more) {
    const rows = page.studies.map(row);
    if (more) list.querySelector("ul").append(...rows);
    else fill(list, el("ul", { class: "cards" }, rows));
    list.querySelector(".more")?.remove();
    if (page.cursor) {
      list.append(
        el("button", { type: "button", class: "more", onclick: () => look(page.cursor) }, "Show more"),
      );
    }
  }

  /** @param {any} record */
  function row(record) {
    const item = el("li", { class: "card", "data-study": record.id });
    redraw(item, record);
    return item;
  }

  /** @param {Element} item @param {any} record */
  function redraw(item, record) {
    const name = record.name || `(no name) ${record.id}`;
    fill(
      item,
      thumbnail(record),
      el(
        "div",
        { class: "grow" },
        el("a", { class: "title", href: `#/studies/${record.id}` }, name),
        el(
          "div",
          { class: "quiet" },
          record.created && `${moment(record.created)} · `,
          el("code", {}, record.id),
          record.submitted_by ? ` · by ${record.submitted_by}` : "",
          record.priority ? ` · priority ${record.priority}` : "",
        ),
        record.message && el("div", { class: "quiet" }, record.message),
        tagList(record.tags, filter.tagged),
        outdatedNote(record),
      ),
      el("div", { class: "state" }, badge(record.state), progressBar(record)),
      actions(record, () => look()),
    );
  }

  /**
   * Follow the first few that are on their way; ask for the list again while there are any.
   *
   * @param {any[]} records
   */
  function listen(records) {
    const active = records.filter((record) => isActive(record.state));
    for (const record of active) {
      if (streams.size >= STREAMS || streams.has(record.id)) continue;
      const stop = follow(record.id, (now, event) => {
        const item = list.querySelector(`[data-study="${CSS.escape(record.id)}"]`);
        if (item && event === "progress" && !item.contains(document.activeElement))
          redraw(item, { ...record, ...now });
        if (event !== "progress") {
          streams.delete(record.id);
          look();
        }
      });
      streams.set(record.id, stop);
    }
    if (active.length > streams.size) timer = setTimeout(look, LOOK_MILLISECONDS);
  }

  await look();
  return () => {
    left = true;
    clearTimeout(timer);
    streams.forEach((stop) => stop());
  };
}

function nothingFound() {
  return el("p", { class: "box" }, "No study matches the search.");
}

async function nothingYet() {
  const { studies } = await vocabulary();
  return el(
    "div",
    { class: "box" },
    el("h2", {}, "No studies yet"),
    el(
      "p",
      {},
      "A study computes a damper’s response over a grid of designs. Start from a scene of the paper, " +
        "change what you like, and watch its map fill.",
    ),
    el(
      "p",
      {},
      "You know the structure, in kg, Hz and mm, and want a damper for it? ",
      el("a", { href: "#/designs/new" }, "Specify a design"),
      ": what must be quiet and what may be chosen, in the units of a drawing.",
    ),
    el(
      "ul",
      { class: "scenes" },
      studies.map((/** @type {any} */ scene) =>
        el(
          "li",
          {},
          el("a", { href: `#/new?scene=${encodeURIComponent(scene.name)}` }, scene.name),
          " ",
          el("span", { class: "quiet" }, prose(firstSentence(scene.about[0]))),
        ),
      ),
    ),
  );
}

/** @param {string} text */
function firstSentence(text) {
  return text.split(/(?<=[.:]) (?=[A-Z`])/)[0].replace(/:$/, ".");
}
