/**
 * Converts the content of a figure into a table of comma-separated values.
 *
 * @typedef {{title?: {text?: string}, type?: string, range?: number[]}} Titled
 * @typedef {{type?: string, name?: string, x: unknown[], y: unknown[], z?: unknown[][], customdata?:
 *   unknown[][], colorbar?: Titled, yaxis?: "y" | "y2"}} Drawn a trace
 * @typedef {{xaxis?: Titled, yaxis?: Titled, yaxis2?: Titled}} Titles
 */

/** @param {Titled | undefined} axis */
function titleOf(axis) {
  return String(axis?.title?.text ?? "").replace(/<[^>]*>/g, "");
}

/** A number without rounding errors: 9 instead of 8.999999999999998. @param {unknown} value */
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
 * A table with one row per point. A row of a map has two coordinates and the value; a row of a curve has the
 * name of the curve and two coordinates.
 *
 * @param {Drawn[]} traces traces of the drawn figure
 * @param {Titles} layout
 * @returns {string}
 */
export function tableOf(traces, layout) {
  const map = traces.find((trace) => trace.type === "heatmap");
  if (map) {
    const values = map.customdata ?? map.z ?? [];
    const head = [titleOf(layout.xaxis), titleOf(layout.yaxis), map.colorbar?.title?.text ?? "value"];
    const rows = map.y.flatMap((y, j) => map.x.map((x, i) => [plain(x), plain(y), values[j][i]]));
    return [head, ...rows].map(line).join("\n") + "\n";
  }
  const axes = { y: titleOf(layout.yaxis), y2: titleOf(layout.yaxis2) };
  const head = ["curve", titleOf(layout.xaxis) || "x", "value", "what"];
  const rows = traces.flatMap((trace) =>
    trace.x.map((x, i) => [trace.name ?? "", plain(x), trace.y[i], axes[trace.yaxis ?? "y"]]),
  );
  return [head, ...rows].map(line).join("\n") + "\n";
}
