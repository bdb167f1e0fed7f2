/** Shows slices: curves of a result along each dimension through the selected point. */
/** @import { MapAnswer, Session } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, el, fill, quiet } from "./dom.js";
import { colour, Figure, thisPoint } from "./figure.js";
import { help } from "./help.js";
import { chosenMeasure } from "./measures.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { DIMENSIONS } from "./vocabulary.js";

const PATIENCE_MILLISECONDS = 150;

export class SlicesPanel {
  trouble = el("div");
  asked = 0;

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    const { selection } = session;
    this.result = chosenMeasure(session, "slice", () => this.look());
    this.charts = selection.varied.map((name) => ({ name, chart: this.chart(name) }));
    this.look = debounced(PATIENCE_MILLISECONDS, () => this.ask());
    selection.addEventListener("chosen", this.look);
    this.element = el(
      "section",
      { class: "box wide" },
      help("page/#explore", "these three views"),
      el("h2", {}, "Slices through the point"),
      quiet(
        "Each figure varies one parameter and holds the others at the point; click to move the point. ",
        selection.worst && "Unless the frequency is chosen, the largest value over all frequencies is shown.",
      ),
      el("div", { class: "row controls" }, this.result.element),
      this.trouble,
      el(
        "div",
        { class: "slices" },
        this.charts.map(({ chart }) => chart.element),
      ),
    );
  }

  /** @param {string} name */
  chart(name) {
    const { selection, record, shown } = this.session;
    return new Figure({
      label: `${shown.title(name)}: slice through the point`,
      name: `slice-${name}-${record.id}`,
      height: 260,
      python: () => pythonLine(record.id, "resonance_map", this.question(name)),
      clicked: ({ pointIndex }) => selection.choose({ [name]: pointIndex }),
    });
  }

  /** The request for a slice, which is a row of a map. @param {string} name */
  question(name) {
    const { selection } = this.session;
    const others = DIMENSIONS.filter((one) => one !== name && one !== FREQUENCY);
    const other = others.find((one) => selection.axes[one].length === 1) ?? others[0];
    const open = selection.worst && name !== FREQUENCY ? [FREQUENCY] : [];
    return { x: name, y: other, metric: this.result.get(), ...selection.at([name, other, ...open]) };
  }

  async ask() {
    const mine = ++this.asked;
    const { charts, trouble } = this;
    try {
      const path = studyPath(this.session.record.id, "resonance-map");
      const answers = await Promise.all(charts.map(({ name }) => ask(path, this.question(name))));
      if (mine !== this.asked || !trouble.isConnected) return;
      fill(trouble);
      await Promise.all(charts.map(({ chart, name }, i) => this.draw(chart, name, answers[i])));
    } catch (error) {
      if (mine === this.asked) fill(trouble, refusalBox(error));
    }
  }

  /** @param {Figure} chart @param {string} name @param {MapAnswer} answer */
  async draw(chart, name, answer) {
    const { selection, shown } = this.session;
    const { x, values, long_name, x_title } = shown.map(answer);
    const row = values[selection.place[answer.y_dimension]];
    const at = selection.place[name];
    const open = name === FREQUENCY && selection.worst;
    await chart.draw(
      () => [
        {
          type: "scatter",
          mode: "lines+markers",
          x,
          y: row,
          line: { color: colour("curve-1"), width: 1.5 },
          marker: { size: 4 },
          name: long_name,
          hovertemplate: "%{x:.5~g}, %{y:.5~g}<extra></extra>",
        },
        ...(open ? [] : [{ ...thisPoint(15), x: [x[at]], y: [row[at]], name: "this point" }]),
      ],
      () => ({
        xaxis: { title: x_title },
        yaxis: { title: long_name, rangemode: "tozero" },
        showlegend: false,
      }),
    );
  }
}
