/**
 * A list of stored studies or designs that is kept up to date. Items can be sorted, compared and deleted.
 *
 * @typedef {{text: string, unit: string, value: number}} Best the value of the best damper of an item
 */
/** @import { Child, Filter, Kept, Listed } from "./types.js" */

import { ask, refusalBox } from "./api.js";
import { checkbox, confirmed, el, fill, picker, say, smallButton } from "./dom.js";
import { counted, moment } from "./numbers.js";
import { actions, isActive } from "./progress.js";

const LOOK_MILLISECONDS = 2000;
const PAGE = 50;
/** Largest number of items that the service lists at once. */
const MOST = 200;
/** Largest number of items that can be compared, which is the number of colours for curves. */
export const MOST_COMPARED = 5;
const SORTS = /** @type {[string, string][]} */ ([
  ["", "newest first"],
  ["best", "best value"],
  ["name", "name"],
]);

/** The name of an item in a list. @param {{id: string, name: string}} record */
export function nameOf({ id, name }) {
  return name || `(no name) ${id}`;
}

/**
 * @template {Listed} T
 * @typedef {{kind: "studies" | "designs", kept: Kept, filter: Filter, none: () => Promise<Child> | Child,
 *   picture?: (record: T) => Child, says: (record: T) => Child[], state: (record: T) => Child[],
 *   best: (record: T, leaving: AbortSignal) => Promise<Best | null>}} Shelved
 */

/** @template {Listed} T */
export class Shelf {
  /** @type {Map<string, {item: HTMLElement, drawn: string}>} */
  cards = new Map();
  /** @type {Map<string, Best | null>} */
  bests = new Map();
  /** @type {Set<string>} */
  chosen = new Set();
  /** @type {Set<string>} */
  acted = new Set();
  /** @type {T[]} */
  records = [];
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  timer;
  leaving = new AbortController();
  asked = 0;
  ul = el("ul", { class: "cards" });
  bar = el("div", { class: "row chosen", role: "group", "aria-label": "Those chosen" });
  more = el("button", { type: "button", class: "more" }, "Show more");
  trouble = el("div");

  /**
   * @param {HTMLElement} list element for the items
   * @param {HTMLElement} controls element for the controls of the list
   * @param {Shelved<T>} what
   */
  constructor(list, controls, what) {
    this.list = list;
    this.what = what;
    this.sort = what.kept.one("sort", ["best", "name"], "");
    const sort = (/** @type {string} */ now) => {
      this.sort = now;
      what.kept.keep({ sort: now });
      void this.look();
    };
    controls.append(picker("Sorted by", SORTS, this.sort, sort));
  }

  leave() {
    this.leaving.abort();
    clearTimeout(this.timer);
  }

  get gone() {
    return this.what.filter.gone();
  }

  /** Request the list again, and draw changed items. @param {string} [cursor] cursor of a further page */
  async look(cursor) {
    clearTimeout(this.timer);
    const mine = ++this.asked;
    const nothing = this.what.filter.nothing();
    if (nothing) return fill(this.list, el("p", { class: "box" }, nothing));
    let page;
    try {
      page = await this.page(cursor);
    } catch (error) {
      if (mine === this.asked) fill(this.list, refusalBox(error));
      return;
    }
    if (this.leaving.signal.aborted || mine !== this.asked) return;
    this.records = cursor ? [...this.records, ...page.records] : page.records;
    const none = this.records.length === 0 && !page.cursor ? await this.what.none() : null;
    if (none) return fill(this.list, none);
    if (!this.ul.isConnected) fill(this.list, this.bar, this.trouble, this.ul);
    this.more.onclick = () => this.look(page.cursor);
    if (page.cursor) this.list.append(this.more);
    else this.more.remove();
    this.show();
    if (this.records.some(({ state }) => isActive(state)))
      this.timer = setTimeout(() => this.look(), LOOK_MILLISECONDS);
  }

  /** @param {string} [cursor] @returns {Promise<{records: T[], cursor: string | undefined}>} */
  async page(cursor) {
    const { kind, filter } = this.what;
    const limit = cursor ? PAGE : Math.min(MOST, Math.max(PAGE, this.records.length, this.sort ? MOST : 0));
    /** @type {unknown} */
    const found = await ask(kind, { ...filter.wanted(), limit, cursor });
    const page = /** @type {Record<typeof kind, T[]> & {cursor: string | null}} */ (found);
    return { records: page[kind], cursor: page.cursor ?? undefined };
  }

  show() {
    const wanted = this.sorted().map((record) => this.card(record));
    const { ul } = this;
    const same = wanted.length === ul.children.length && wanted.every((item, i) => ul.children[i] === item);
    // items are moved only if their order has changed, because a moved element loses the keyboard focus
    if (!same) fill(ul, wanted);
    for (const id of this.chosen) if (!this.records.some((one) => one.id === id)) this.chosen.delete(id);
    this.drawBar();
  }

  /** Sort the items. A sort by best value groups items by unit, and puts items without a value last. */
  sorted() {
    if (this.sort === "name") return [...this.records].sort((a, b) => a.name.localeCompare(b.name));
    if (this.sort !== "best") return this.records;
    const key = (/** @type {T} */ one) => this.bests.get(one.id) ?? { unit: "\uffff", value: 0 };
    return [...this.records].sort((a, b) => {
      const [one, other] = [key(a), key(b)];
      return one.unit.localeCompare(other.unit) || one.value - other.value;
    });
  }

  /** @param {T} record */
  card(record) {
    const { id } = record;
    const known = this.cards.get(id) ?? { item: el("li", { class: "card", "data-study": id }), drawn: "" };
    this.cards.set(id, known);
    const drawn = JSON.stringify([record, this.gone]);
    const held = known.item.contains(document.activeElement);
    const mine = this.acted.delete(id);
    // an item with the keyboard focus is not drawn again, unless the user has pressed one of its buttons
    if (known.drawn === drawn || (held && known.drawn && !mine)) return known.item;
    known.drawn = drawn;
    this.draw(known.item, record);
    if (held) known.item.querySelector("a")?.focus();
    return known.item;
  }

  /** @param {HTMLElement} item @param {T} record */
  draw(item, record) {
    const { kind, picture, says, state } = this.what;
    const best = el("div", { class: "best" });
    fill(
      item,
      this.chooser(record),
      picture?.(record),
      el(
        "div",
        { class: "grow" },
        el("a", { class: "title", href: this.gone ? null : `#/${kind}/${record.id}` }, nameOf(record)),
        el("div", { class: "quiet" }, `${moment(record.created)} · `, el("code", {}, record.id)),
        says(record),
      ),
      best,
      el("div", { class: "state" }, state(record)),
      actions(kind, record, () => (this.acted.add(record.id), this.look()), this.gone),
    );
    void this.drawBest(best, record);
  }

  /** @param {T} record */
  chooser(record) {
    const choose = (/** @type {boolean} */ on) => {
      if (on) this.chosen.add(record.id);
      else this.chosen.delete(record.id);
      this.drawBar();
    };
    const label = checkbox("", this.chosen.has(record.id), choose);
    label.querySelector("input")?.setAttribute("aria-label", `Choose ${nameOf(record)}`);
    return label;
  }

  /** @param {HTMLElement} place @param {T} record */
  async drawBest(place, record) {
    // `await` is used even without a request, so that the item is in the page before it is filled
    const best = await (this.gone ? null : this.what.best(record, this.leaving.signal));
    this.bests.set(record.id, best);
    if (best) fill(place, el("span", { class: "quiet" }, "best "), el("strong", {}, best.text));
    if (this.sort === "best" && !this.leaving.signal.aborted) this.show();
  }

  drawBar() {
    const { chosen, what } = this;
    if (this.gone) chosen.clear();
    if (chosen.size === 0) return fill(this.bar);
    const compare = `#/compare?${what.kind}=${[...chosen].join(",")}`;
    fill(
      this.bar,
      `${chosen.size} chosen`,
      chosen.size > 1 &&
        chosen.size <= MOST_COMPARED &&
        el("a", { class: "button small", href: compare }, "Compare"),
      smallButton("Delete", () => this.remove()),
      smallButton("Choose none", () => (chosen.clear(), this.redraw())),
    );
  }

  redraw() {
    for (const known of this.cards.values()) known.drawn = "";
    this.show();
  }

  async remove() {
    const { kind } = this.what;
    const noun = kind === "studies" ? "study" : "design";
    const these = this.chosen.size === 1 ? `this ${noun}` : `these ${this.chosen.size} ${kind}`;
    const text = "They can be restored from the trash for a week.";
    if (!(await confirmed(`Delete ${these}?`, text, "Delete"))) return;
    fill(this.trouble);
    let gone = 0;
    for (const id of [...this.chosen]) {
      try {
        await ask(`${kind}/${encodeURIComponent(id)}`, { trash: true }, { method: "DELETE" });
        this.chosen.delete(id);
        gone += 1;
      } catch (error) {
        this.trouble.append(refusalBox(error));
      }
    }
    say(`${counted(gone, "deletion")}.`);
    await this.look();
  }
}
