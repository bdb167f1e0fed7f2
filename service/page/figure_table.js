/** What a figure shows, as a table of comma-separated values. */

/** @param {any} axis */
function titleOf(axis) {
  return String(axis?.title?.text ?? "").replace(/<[^>]*>/g, "");
}

/**
 * A place on an axis without what turning a ratio into a unit leaves in its last digit: 9, not
 * 8.999999999999998.
 *
 * @param {unknown} value
 */
function plain(value) {
  return typeof value === "number" ? Number(value.toPrecision(15)) : value;
}

/** @param {unknown[]} row */
function line(row) {
  return row
    .map((cell) =>
      cell === null || cell === undefined
        ? ""
        : /[",\n]/.test(String(cell))
          ? `"${String(cell).replaceAll('"', '""')}"`
          : String(cell),
    )
    .join(",");
}

/**
 * One row a point: of a map its two coordinates and the value; of curves the curve's name and both
 * coordinates.
 *
 * @param {any[]} traces as they were drawn
 * @param {any} layout
 * @returns {string}
 */
export function tableOf(traces, layout) {
  const map = traces.find((trace) => trace.type === "heatmap");
  if (map) {
    const values = map.customdata ?? map.z;
    const head = [titleOf(layout.xaxis), titleOf(layout.yaxis), map.colorbar?.title?.text ?? "value"];
    const rows = map.y.flatMap((/** @type {number} */ y, /** @type {number} */ j) =>
      map.x.map((/** @type {number} */ x, /** @type {number} */ i) => [plain(x), plain(y), values[j][i]]),
    );
    return [head, ...rows].map(line).join("\n") + "\n";
  }
  const axes = { y: titleOf(layout.yaxis), y2: titleOf(layout.yaxis2) };
  const head = ["curve", titleOf(layout.xaxis) || "x", "value", "what"];
  const rows = traces.flatMap((trace) =>
    trace.x.map((/** @type {any} */ x, /** @type {number} */ i) => [
      trace.name ?? "",
      plain(x),
      trace.y[i],
      axes[/** @type {"y" | "y2"} */ (trace.yaxis ?? "y")],
    ]),
  );
  return [head, ...rows].map(line).join("\n") + "\n";
}
