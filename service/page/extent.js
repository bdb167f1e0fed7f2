/** How far values reach, and whether their logarithms tell more. */

/** Values that differ more than this are coloured by their logarithm. */
const WIDE = 20;

/**
 * The least and the greatest of what is known; not a number of two where nothing is.
 *
 * @param {(number | null)[][]} rows
 */
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

/** Whether values of that extent are coloured by their logarithm. @param {number[]} extent */
export function isWide([low, high]) {
  return low > 0 && high > WIDE * low;
}
