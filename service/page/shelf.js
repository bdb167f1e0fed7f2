/**
 * A list of what is kept, studies or designs: live, and with cards that are sorted, compared and deleted
 * together.
 *
 * @typedef {{id: string, name: string, state: string, created: string}} Listed
 * @typedef {{text: string, unit: string, value: number}} Best what the best damper of it reaches
 */

import { ask, refusalBox } from "./api.js";
import { checkbox, confirmed, el, fill, picker, say } from "./dom.js";
import { counted, moment } from "./numbers.js";
import { isActive } from "./progress.js";

const LOOK_MILLISECONDS = 2000;
const PAGE = 50;
/** The most that the service lists at once. */
const MOST = 200;
/** As many as there are colours of curves. */
export const MOST_COMPARED = 5;
const SORTS = /** @type {[string, string][]} */ ([
  ["", "newest first"],
  ["best", "best value"],
  ["name", "name"],
]);

/** What something is called in a list. @param {{id: string, name: string}} record */
export function nameOf({ id, name }) {
  return name || `(no name) ${id}`;
}

/**
 * @template {Listed} T
 * @param {HTMLElement} list where the cards are
 * @param {HTMLElement} controls where the controls over all of them are
 * @param {{kind: "studies" | "designs", kept: import("./kept.js").Kept, wanted: () => Record<string,
 *   unknown>, nothing: () => string, gone?: () => boolean, none: () => Promise<import("./dom.js").Child> |
 *   import("./dom.js").Child, picture?: (record: T) => import("./dom.js").Child, says: (record: T) =>
 *   import("./dom.js").Child[], state: (record: T) => import("./dom.js").Child[], best: (record: T) =>
 *   Promise<Best | null>, actions?: (record: T, acted: () => void) => import("./dom.js").Child}} what
 *   `nothing` says why nothing can be meant, where that is known without asking
 * @returns {{look: () => Promise<void>, leave: () => void}}
 */
export function shelf(list, controls, what) {
  const { kind, kept } = what;
  /** @type {Map<string, {item: HTMLElement, drawn: string}>} */
  const cards = new Map();
  /** @type {Map<string, Best | null>} */
  const bests = new Map();
  /** @type {Set<string>} */
  const chosen = new Set();
  /** @type {Set<string>} */
  const acted = new Set();
  /** @type {T[]} */
  let records = [];
  let sort = kept.one("sort", ["best", "name"], "");
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  let left = false;
  let asked = 0;
  const ul = el("ul", { class: "cards" });
  const bar = el("div", { class: "row chosen", role: "group", "aria-label": "Those chosen" });
  const more = el("button", { type: "button", class: "more" }, "Show more");
  const trouble = el("div");

  /**
   * Ask anew; what is shown stays as it is where nothing has changed.
   *
   * @param {string} [cursor] of a further page
   */
  async function look(cursor) {
    clearTimeout(timer);
    const mine = ++asked;
    const nothing = what.nothing();
    if (nothing) return fill(list, el("p", { class: "box" }, nothing));
    const limit = cursor ? PAGE : Math.min(MOST, Math.max(PAGE, records.length, sort ? MOST : 0));
    let page;
    try {
      page = await ask(kind, { ...what.wanted(), limit, cursor });
    } catch (error) {
      if (mine === asked) fill(list, refusalBox(error));
      return;
    }
    if (left || mine !== asked) return;
    records = cursor ? [...records, ...page[kind]] : page[kind];
    const none = records.length === 0 && !page.cursor ? await what.none() : null;
    if (none) return fill(list, none);
    if (!ul.isConnected) fill(list, bar, trouble, ul);
    more.onclick = () => look(page.cursor);
    if (page.cursor) list.append(more);
    else more.remove();
    show();
    if (records.some(({ state }) => isActive(state))) timer = setTimeout(look, LOOK_MILLISECONDS);
  }

  function show() {
    const wanted = sorted().map(card);
    const same = wanted.length === ul.children.length && wanted.every((item, i) => ul.children[i] === item);
    // an element that is moved loses the keyboard
    if (!same) fill(ul, wanted);
    for (const id of chosen) if (!records.some((one) => one.id === id)) chosen.delete(id);
    drawBar();
  }

  /** Those without a best value come last; values in unlike units are not mixed. */
  function sorted() {
    if (sort === "name") return [...records].sort((a, b) => a.name.localeCompare(b.name));
    if (sort !== "best") return records;
    const key = (/** @type {T} */ one) => bests.get(one.id) ?? { unit: "\uffff", value: 0 };
    return [...records].sort((a, b) => {
      const [one, other] = [key(a), key(b)];
      return one.unit.localeCompare(other.unit) || one.value - other.value;
    });
  }

  /** @param {T} record */
  function card(record) {
    const known = cards.get(record.id) ?? {
      item: el("li", { class: "card", "data-study": record.id }),
      drawn: "",
    };
    cards.set(record.id, known);
    const drawn = JSON.stringify([record, what.gone?.()]);
    const held = known.item.contains(document.activeElement);
    const mine = acted.delete(record.id);
    // what somebody holds stays as it is while it goes on, but not what was acted on
    if (known.drawn === drawn || (held && known.drawn && !mine)) return known.item;
    known.drawn = drawn;
    draw(known.item, record);
    if (held) known.item.querySelector("a")?.focus();
    return known.item;
  }

  /** @param {HTMLElement} item @param {T} record */
  function draw(item, record) {
    const name = nameOf(record);
    const best = el("div", { class: "best" });
    const choose = checkbox("", chosen.has(record.id), (on) => {
      if (on) chosen.add(record.id);
      else chosen.delete(record.id);
      drawBar();
    });
    choose.querySelector("input").setAttribute("aria-label", `Choose ${name}`);
    fill(
      item,
      choose,
      what.picture?.(record),
      el(
        "div",
        { class: "grow" },
        el("a", { class: "title", href: what.gone?.() ? null : `#/${kind}/${record.id}` }, name),
        el("div", { class: "quiet" }, `${moment(record.created)} · `, el("code", {}, record.id)),
        what.says(record),
      ),
      best,
      el("div", { class: "state" }, what.state(record)),
      what.actions?.(record, () => (acted.add(record.id), look())),
    );
    void drawBest(best, record);
  }

  /** @param {HTMLElement} place @param {T} record */
  async function drawBest(place, record) {
    // always later: what is drawn now is put in its place first
    const best = await (what.gone?.() ? null : what.best(record));
    bests.set(record.id, best);
    if (best) fill(place, el("span", { class: "quiet" }, "best "), el("strong", {}, best.text));
    if (sort === "best" && !left) show();
  }

  function drawBar() {
    if (what.gone?.()) chosen.clear();
    const several = chosen.size > 1 && chosen.size <= MOST_COMPARED;
    const button = (/** @type {string} */ label, /** @type {() => void} */ onclick) =>
      el("button", { type: "button", class: "small", onclick }, label);
    fill(
      bar,
      chosen.size > 0 && [
        `${chosen.size} chosen`,
        several &&
          el("a", { class: "button small", href: `#/compare?${kind}=${[...chosen].join(",")}` }, "Compare"),
        button("Delete", remove),
        button("Choose none", () => (chosen.clear(), redraw())),
      ],
    );
  }

  function redraw() {
    for (const known of cards.values()) known.drawn = "";
    show();
  }

  async function remove() {
    const noun = kind === "studies" ? "study" : "design";
    const these = chosen.size === 1 ? `this ${noun}` : `these ${chosen.size} ${kind}`;
    const text =
      kind === "studies" ? "They can be restored from the trash for a week." : "Their studies stay.";
    if (!(await confirmed(`Delete ${these}?`, text, "Delete"))) return;
    fill(trouble);
    let gone = 0;
    for (const id of [...chosen]) {
      try {
        await ask(
          `${kind}/${encodeURIComponent(id)}`,
          { trash: kind === "studies" || null },
          { method: "DELETE" },
        );
        chosen.delete(id);
        gone += 1;
      } catch (error) {
        trouble.append(refusalBox(error));
      }
    }
    say(`${counted(gone, "deletion")}.`);
    await look();
  }

  controls.append(
    picker("Sorted by", SORTS, sort, (now) => {
      sort = now;
      kept.keep({ sort });
      void look();
    }),
  );
  return {
    look: () => look(),
    leave: () => {
      left = true;
      clearTimeout(timer);
    },
  };
}
