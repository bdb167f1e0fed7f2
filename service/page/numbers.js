/** Writes numbers, times and sizes as text, and finds the smallest and the largest of several numbers. */

/**
 * A number with a few significant digits.
 *
 * @param {number | null | undefined} value
 * @param {number} [digits]
 */
export function short(value, digits = 5) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e7))
    return value.toExponential(Math.max(0, digits - 3)).replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
}

/** A count with separators. @param {number} value */
export function count(value) {
  return value.toLocaleString("en-US");
}

/** @param {number} value @param {string} noun */
export function counted(value, noun) {
  return `${count(value)} ${noun}${value === 1 ? "" : "s"}`;
}

/**
 * A quantity as on a drawing, with lengths in millimetres.
 *
 * @param {number} value
 * @param {string} units in SI
 * @param {number} digits
 */
export function drawn(value, units, digits) {
  return units === "m" || units === "m/s"
    ? `${short(1000 * value, digits)} m${units}`
    : `${short(value, digits)} ${units}`;
}

/** A duration as text. @param {number | null | undefined} seconds */
export function duration(seconds) {
  if (seconds === null || seconds === undefined) return "–";
  if (seconds < 1e-3) return `${short(seconds * 1e6, 3)} µs`;
  if (seconds < 1) return `${short(seconds * 1e3, 3)} ms`;
  if (seconds < 90) return `${short(seconds, 2)} s`;
  if (seconds < 5400) return `${short(seconds / 60, 2)} min`;
  if (seconds < 129600) return `${short(seconds / 3600, 3)} h`;
  return `${short(seconds / 86400, 3)} days`;
}

/** A size in bytes. @param {number} bytes */
export function size(bytes) {
  const units = ["bytes", "kB", "MB", "GB", "TB", "PB"];
  let step = 0;
  while (bytes >= 1000 && step < units.length - 1) {
    bytes /= 1000;
    step += 1;
  }
  return `${short(bytes, 3)} ${units[step]}`;
}

/** Date and time in the time zone of the browser. @param {string | null} iso */
export function moment(iso) {
  if (!iso) return "–";
  return new Date(iso).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });
}

/** Whether values grow by a constant factor, not by a constant step. @param {number[]} values */
export function isLogarithmic(values) {
  if (values.length < 3 || values[0] <= 0) return false;
  const last = values[values.length - 1];
  const factor = (last / values[0]) ** (1 / (values.length - 1));
  return factor > 1.05 && values.every((value, i) => Math.abs(value / (values[0] * factor ** i) - 1) < 1e-6);
}

/** The index of the value nearest to `wanted`. @param {number[]} values @param {number} wanted */
export function nearest(values, wanted) {
  let best = 0;
  values.forEach((value, i) => {
    if (Math.abs(value - wanted) < Math.abs(values[best] - wanted)) best = i;
  });
  return best;
}

/** Ratio of the largest to the smallest value above which values are coloured by their logarithm. */
const WIDE = 20;

/** The smallest and the largest known value, or NaN. @param {(number | null)[][]} rows */
export function extentOf(rows) {
  let [low, high] = [NaN, NaN];
  for (const row of rows) {
    for (const value of row) {
      if (value === null) continue;
      if (!(value >= low)) low = value;
      if (!(value <= high)) high = value;
    }
  }
  return [low, high];
}

/** Whether values with this extent are coloured by their logarithm. @param {number[]} extent */
export function isWide([low, high]) {
  return low > 0 && high > WIDE * low;
}
