/** A small picture of a study's map, for the list of studies: asked for where it is seen, and once. */
/** @import { StudyRecord } from "./types.js" */

import { ask, Refusal, studyPath } from "./api.js";
import { el } from "./dom.js";
import { extentOf, isWide } from "./numbers.js";
import { orderOf } from "./vocabulary.js";

/** Values along either axis of a picture. */
const MOST = 32;
/** A picture of a larger study would make the service read more than a glance is worth. */
export const LARGEST = 1_000_000;
/** Pictures that are asked for at once. */
const AT_ONCE = 2;
/** A study that goes on is drawn again after each such share of it. */
const STEPS = 5;
/** Cividis as matplotlib has it, at nine even places: the colours of the maps. */
const CIVIDIS = [
  [0, 34, 78],
  [26, 56, 111],
  [67, 78, 108],
  [97, 101, 111],
  [125, 124, 120],
  [155, 148, 118],
  [188, 174, 108],
  [222, 201, 88],
  [254, 232, 56],
];

/**
 * The pictures that have been begun, by study and how much of it was there.
 *
 * @type {Map<string, HTMLCanvasElement>}
 */
const begun = new Map();
/**
 * What a canvas on the page is to show, until it has been seen.
 *
 * @type {WeakMap<Element, () => Promise<void>>}
 */
const waiting = new WeakMap();
/** @type {(() => Promise<void>)[]} */
const queue = [];
let underWay = 0;

const seen = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    const draw = waiting.get(target);
    if (!isIntersecting || !draw) continue;
    waiting.delete(target);
    seen.unobserve(target);
    queue.push(draw);
  }
  void work();
});

/**
 * The picture of a study, empty until it has been seen and drawn.
 *
 * @param {StudyRecord} record as in the list
 * @returns {HTMLElement} a place of the picture's size that says why where there is nothing to draw
 */
export function thumbnail(record) {
  const plane = planeOf(record);
  if (!plane) return el("span", { class: "thumbnail" }, whyNone(record));
  const key = `${record.id} ${Math.floor((STEPS * record.points_done) / record.points_total)}`;
  const known = begun.get(key);
  if (known) return known;
  const canvas = el("canvas", { class: "thumbnail", width: 1, height: 1, "aria-hidden": "true" });
  begun.set(key, canvas);
  waiting.set(canvas, async () => {
    // asked again where it could not be had: the list itself says what is wrong
    if (!(await drawn(canvas, record.id, plane))) begun.delete(key);
  });
  seen.observe(canvas);
  return canvas;
}

/**
 * The dimensions of a picture; none where nothing can be shown.
 *
 * @param {StudyRecord} record
 */
function planeOf(record) {
  // a study that has ended half-way may have nothing of the plane, and is refused then
  const there =
    record.points_done > 0 && (record.state === "running" || record.points_done === record.points_total);
  if (!there || record.points_total > LARGEST) return null;
  const [x, y] = orderOf(record.dimensions).filter(
    (name) => record.shape[record.dimensions.indexOf(name)] > 1,
  );
  return y ? { x, y } : null;
}

/** Why a study has no picture, in a few words. @param {StudyRecord} record */
function whyNone(record) {
  if (record.points_done === 0) return "nothing computed yet";
  if (record.points_total > LARGEST) return "too large for a picture";
  if (record.points_done < record.points_total && record.state !== "running")
    return "partly computed, no picture";
  return "one axis, no map";
}

async function work() {
  if (underWay >= AT_ONCE) return;
  const draw = queue.shift();
  if (!draw) return;
  underWay += 1;
  void work();
  try {
    await draw();
  } finally {
    underWay -= 1;
    void work();
  }
}

/**
 * Draw a picture; false where the study is gone or the service away.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {string} id
 * @param {{x: string, y: string}} plane
 */
async function drawn(canvas, id, plane) {
  try {
    paint(canvas, (await ask(studyPath(id, "resonance-map"), { ...plane, most: MOST })).values);
    return true;
  } catch (error) {
    if (error instanceof Refusal) return false;
    throw error;
  }
}

/**
 * One pixel a value, the first row at the bottom.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {(number | null)[][]} rows
 */
function paint(canvas, rows) {
  [canvas.width, canvas.height] = [rows[0].length, rows.length];
  // so few pixels are not worth a place in the memory of the graphics card
  const context = canvas.getContext("2d", { willReadFrequently: true });
  const extent = extentOf(rows);
  if (!context || Number.isNaN(extent[0])) return;
  const law = isWide(extent) ? Math.log : (/** @type {number} */ value) => value;
  const [low, high] = extent.map(law);
  const image = context.createImageData(canvas.width, canvas.height);
  rows
    .toReversed()
    .forEach((row, j) =>
      row.forEach(
        (value, i) =>
          value !== null &&
          image.data.set([...shade((law(value) - low) / (high - low || 1)), 255], 4 * (j * canvas.width + i)),
      ),
    );
  context.putImageData(image, 0, 0);
}

/** @param {number} share from 0 to 1 */
function shade(share) {
  const place = Math.min(share * (CIVIDIS.length - 1), CIVIDIS.length - 1.000001);
  const [from, to] = [CIVIDIS[Math.floor(place)], CIVIDIS[Math.floor(place) + 1]];
  return from.map((part, i) => part + (to[i] - part) * (place % 1));
}
