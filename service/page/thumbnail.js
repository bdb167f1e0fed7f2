/** A small picture of a study's map, for the list of studies. It is requested when it becomes visible. */
/** @import { StudyRecord } from "./types.js" */

import { ask, Refusal, studyPath } from "./api.js";
import { el } from "./dom.js";
import { extentOf, isWide } from "./numbers.js";
import { Turns } from "./turns.js";
import { orderOf } from "./vocabulary.js";

/** Largest number of values along each axis of a picture. */
const MOST = 32;
/** Largest number of points of a study with a picture. For a larger study the service would read too much. */
export const LARGEST = 1_000_000;
/** Number of times that the picture of a running study is redrawn, after equal shares of the points. */
const STEPS = 5;
/** The colours of maps: nine equally spaced colours of matplotlib's colour scale cividis. */
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

/** The existing pictures, by study and progress. @type {Map<string, HTMLCanvasElement>} */
const begun = new Map();
/** The functions that draw canvases once they are visible. @type {WeakMap<Element, () => Promise<void>>} */
const waiting = new WeakMap();
const turns = new Turns(2);

const seen = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    const draw = waiting.get(target);
    if (!isIntersecting || !draw) continue;
    waiting.delete(target);
    seen.unobserve(target);
    void turns.run(draw);
  }
});

/**
 * The picture of a study. It is empty until it becomes visible and is drawn.
 *
 * @param {StudyRecord} record record as in the list of studies
 * @returns {HTMLElement} the picture, or an element that gives the reason why there is no picture
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
    // a picture that failed is requested again with the next list, which reports the fault
    if (!(await drawn(canvas, record.id, plane))) begun.delete(key);
  });
  seen.observe(canvas);
  return canvas;
}

/** The two dimensions of a picture, if the study has two. @param {StudyRecord} record */
function planeOf(record) {
  // a study that stopped early may have no point in the plane; the service would refuse the request
  const there =
    record.points_done > 0 && (record.state === "running" || record.points_done === record.points_total);
  if (!there || record.points_total > LARGEST) return null;
  const [x, y] = orderOf(record.dimensions).filter(
    (name) => record.shape[record.dimensions.indexOf(name)] > 1,
  );
  return y ? { x, y } : null;
}

/** The reason why a study has no picture, in a few words. @param {StudyRecord} record */
function whyNone(record) {
  if (record.points_done === 0) return "nothing computed yet";
  if (record.points_total > LARGEST) return "too large for a picture";
  if (record.points_done < record.points_total && record.state !== "running")
    return "partly computed, no picture";
  return "one axis, no map";
}

/**
 * Draw a picture. Return false if the study was deleted or the service does not answer.
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
 * Paint one pixel for each value, with the first row at the bottom.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {(number | null)[][]} rows
 */
function paint(canvas, rows) {
  [canvas.width, canvas.height] = [rows[0].length, rows.length];
  // a canvas as small as this need not be in the memory of the graphics card
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
