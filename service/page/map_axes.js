/** The two dimensions of a map, which are kept in the address, and the position of the point on the map. */
/** @import { MapAnswer, Session, Shown } from "./types.js" */

import { picker } from "./dom.js";

export class MapAxes {
  /**
   * @param {Session} session
   * @param {string[]} usual default dimensions; the map shows the first two
   * @param {string[]} choices
   */
  constructor(session, [x, y], choices) {
    this.session = session;
    this.usual = { x, y };
    this.x = session.kept.one("x", choices, x);
    this.y = session.kept.one("y", choices, y);
    if (this.x === this.y) Object.assign(this, this.usual);
  }

  /** Both dimensions, as parameters of a question. */
  get both() {
    return { x: this.x, y: this.y };
  }

  /** Both dimensions as they are kept in the address; null if they are the default dimensions. */
  get kept() {
    const usual = this.x === this.usual.x && this.y === this.usual.y;
    return usual ? { x: null, y: null } : this.both;
  }

  /** The position of the selected point on the map, in the shown units. */
  get point() {
    const { selection, shown } = this.session;
    const at = (/** @type {string} */ name) => selection.value(name) * shown.factor(name);
    return { x: at(this.x), y: at(this.y) };
  }

  /**
   * Move the point of the study to a clicked position.
   *
   * @param {{x: number, y: number}} point
   * @param {number | undefined} rows number of rows of the map; a map with one row has no dimension y
   */
  choose(point, rows) {
    const { selection, shown } = this.session;
    const x = { [this.x]: point.x / shown.factor(this.x) };
    selection.chooseValues(rows === 1 ? x : { ...x, [this.y]: point.y / shown.factor(this.y) });
  }

  /**
   * Pickers of the two dimensions. If both would show the same dimension, the dimensions are swapped.
   *
   * @param {string[]} choices
   * @param {() => void} changed
   */
  pickers(choices, changed) {
    const { shown } = this.session;
    const names = /** @type {[string, string][]} */ (choices.map((name) => [name, shown.title(name)]));
    /** @param {"x" | "y"} mine @param {"x" | "y"} other */
    const exchange = (mine, other) => (/** @type {string} */ name) => {
      if (this[other] === name) this[other] = this[mine];
      this[mine] = name;
      changed();
    };
    return [
      picker("Across", names, this.x, exchange("x", "y")),
      picker("Up", names, this.y, exchange("y", "x")),
    ];
  }
}

/** The computed share, the failures and the note of a map. @param {MapAnswer} map @param {Shown} shown */
export function said(map, shown) {
  const share = map.complete < 1 ? `${Math.floor(100 * map.complete)} % of this map is computed. ` : "";
  const failed = map.points_failed ? `${map.points_failed} points failed. ` : "";
  return share + failed + shown.words(map).note;
}
