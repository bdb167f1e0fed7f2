/** A sketch of the model at rest, with the symbols of a specification. */

import { coil, cylinder, svg } from "./sketch.js";

const WIDTH = 560;
const HEIGHT = 220;
const WALL = 70;
const MIDDLE = 350;
const FLOOR = 170;
const HALF = 90;

/** @param {number} x @param {number} y @param {string} words @param {string} [sub] an index */
function label(x, y, words, sub) {
  const text = svg("text", { x, y });
  text.textContent = words;
  if (sub) {
    const index = svg("tspan", { dy: 4, class: "index" });
    index.textContent = sub;
    text.append(index);
  }
  return text;
}

const PARTICLE = ", with the particle m, which has the clearance d on either side and rebounds with e";

/**
 * The sketch of the model, in which a particle is optional.
 *
 * @param {boolean} particle whether to draw a particle
 */
export function modelSketch(particle = true) {
  const box = HALF + 28;
  const length = MIDDLE - box - WALL;
  const picture = svg("svg", {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
    class: "sketch model",
    role: "img",
    "aria-label":
      "The structure M on spring k and dashpot c, with the friction force F_f on its shaken base " +
      `z${particle ? PARTICLE : ""}`,
  });
  picture.append(
    svg("path", { d: `M${WALL},20 V${FLOOR} H${WIDTH - 20}`, class: "line thick" }),
    svg("path", { d: coil(length), class: "line", transform: `translate(${WALL},62)` }),
    svg("path", { d: cylinder(length), class: "line", transform: `translate(${WALL},100)` }),
    svg("rect", { x: MIDDLE - box, y: 36, width: 2 * box, height: 90, rx: 4, class: "mass" }),
    svg("rect", { x: MIDDLE - 26, y: 126, width: 52, height: FLOOR - 128, class: "pad sticks" }),
    svg("path", {
      d: `M20,${FLOOR + 24} H${WALL} M${WALL},${FLOOR + 24} l-9,-5 M${WALL},${FLOOR + 24} l-9,5`,
      class: "line",
    }),
    label(28, FLOOR + 16, "z"),
    label(WALL + length / 2 - 4, 46, "k"),
    label(WALL + length / 2 - 4, 134, "c"),
    label(MIDDLE - box + 8, 54, "M"),
    label(MIDDLE + 36, FLOOR - 12, "F", "f"),
  );
  if (particle) {
    picture.append(
      svg("rect", { x: MIDDLE - HALF, y: 64, width: 2 * HALF, height: 40, class: "cavity" }),
      svg("path", { d: `M${MIDDLE - HALF},64 V104 M${MIDDLE + HALF},64 V104`, class: "line thick" }),
      svg("circle", { cx: MIDDLE, cy: 84, r: 14, class: "particle" }),
      svg("path", { d: `M${MIDDLE + 14},84 H${MIDDLE + HALF}`, class: "line" }),
      label(MIDDLE + 46, 80, "d"),
      label(MIDDLE - 34, 80, "m"),
      label(MIDDLE - HALF + 6, 100, "e"),
    );
  }
  return picture;
}
