/** Slices: a result along every axis through the selected point. */
/** @import { Figure, MapAnswer, Session } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, el, fill } from "./dom.js";
import { colour, figure } from "./figure.js";
import { help } from "./help.js";
import { chosenMeasure } from "./measures.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { DIMENSIONS } from "./vocabulary.js";

const PATIENCE_MILLISECONDS = 150;

/** @param {Session} session @returns {{element: HTMLElement, look: () => void}} */
export function slicesPanel(session) {
  const { selection, record, shown } = session;
  const result = chosenMeasure(session, "slice", () => look());
  const trouble = el("div");
  const charts = selection.varied.map((name) => ({
    name,
    chart: figure({
      label: `${shown.title(name)}: slice through the point`,
      name: `slice-${name}-${record.id}`,
      height: 260,
      python: () => pythonLine(record.id, "resonance_map", question(name)),
      clicked: ({ pointIndex }) => selection.choose({ [name]: pointIndex }),
    }),
  }));
  let asked = 0;

  /** A map of one row, or the row of a map at which the point lies. @param {string} name */
  function question(name) {
    const fixed = DIMENSIONS.find(
      (one) => one !== name && one !== FREQUENCY && selection.axes[one].length === 1,
    );
    const other =
      fixed ?? /** @type {string} */ (DIMENSIONS.find((one) => one !== name && one !== FREQUENCY));
    const open = selection.worst && name !== FREQUENCY ? [FREQUENCY] : [];
    return { x: name, y: other, metric: result.get(), ...selection.at([name, other, ...open]) };
  }

  const look = debounced(PATIENCE_MILLISECONDS, async () => {
    const mine = ++asked;
    try {
      const path = studyPath(record.id, "resonance-map");
      const answers = await Promise.all(charts.map(({ name }) => ask(path, question(name))));
      if (mine !== asked || !trouble.isConnected) return;
      fill(trouble);
      await Promise.all(charts.map(({ chart, name }, i) => draw(chart, name, answers[i])));
    } catch (error) {
      if (mine === asked) fill(trouble, refusalBox(error));
    }
  });

  /** @param {Figure} chart @param {string} name @param {MapAnswer} answer */
  async function draw(chart, name, answer) {
    const map = shown.map(answer);
    const row = map.values[selection.place[answer.y_dimension]];
    const at = selection.place[name];
    const open = name === FREQUENCY && selection.worst;
    await chart.draw(
      () => [
        {
          type: "scatter",
          mode: "lines+markers",
          x: map.x,
          y: row,
          line: { color: colour("curve-1"), width: 1.5 },
          marker: { size: 4 },
          name: map.long_name,
          hovertemplate: "%{x:.5~g}, %{y:.5~g}<extra></extra>",
        },
        ...(open
          ? []
          : [
              {
                type: "scatter",
                mode: "markers",
                x: [map.x[at]],
                y: [row[at]],
                name: "this point",
                hoverinfo: "skip",
                marker: { symbol: "circle-open", size: 15, color: "#ff3030", line: { width: 2.5 } },
              },
            ]),
      ],
      () => ({
        xaxis: { title: { text: map.x_title } },
        yaxis: { title: { text: map.long_name }, rangemode: "tozero" },
        showlegend: false,
      }),
    );
  }

  selection.addEventListener("chosen", look);
  const element = el(
    "section",
    { class: "box wide" },
    help("page/#explore", "these three views"),
    el("h2", {}, "Slices through the point"),
    el(
      "p",
      { class: "quiet" },
      "Each figure varies one parameter and holds the others at the point; click to move the point. ",
      selection.worst && "Unless the frequency is chosen, the largest value over all frequencies is shown.",
    ),
    el("div", { class: "row controls" }, result.element),
    trouble,
    el(
      "div",
      { class: "slices" },
      charts.map(({ chart }) => chart.element),
    ),
  );
  return { element, look };
}
