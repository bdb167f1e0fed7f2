/** Points that were pinned: their frequency responses in one figure, beside that of the point. */
/** @import { Session } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { debounced, el, fill } from "./dom.js";
import { CURVES, DASHES, figure } from "./figure.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";

const PATIENCE_MILLISECONDS = 200;
/** As many as there are kinds of line beside the point's own. */
const MOST = 4;

/** @param {Session} session @returns {{element: HTMLElement, look: () => void}} */
export function pinsPanel(session) {
  const { selection, record, kept, shown } = session;
  const along = selection.varied.filter((name) => name !== FREQUENCY);
  const chart = figure({
    label: "Frequency responses of the point and of pinned points",
    name: `pinned-${record.id}`,
    height: 300,
    python: () => pythonLine(record.id, "frequency_response", selection.at([FREQUENCY])),
  });
  const list = el("ul", { class: "plain" });
  const trouble = el("div");
  let pins = readPins();
  let asked = 0;

  /** Places along the dimensions, of pins that lie in the study. @returns {number[][]} */
  function readPins() {
    const read = (kept.values.pins ?? "")
      .split(",")
      .filter(Boolean)
      .map((text) => text.split(".").map(Number));
    return read
      .filter(
        (pin) =>
          pin.length === along.length &&
          pin.every(
            (place, i) => Number.isInteger(place) && place >= 0 && place < selection.axes[along[i]].length,
          ),
      )
      .slice(0, MOST);
  }

  /** @param {number[][]} now */
  function keep(now) {
    pins = now;
    kept.keep({ pins: pins.map((pin) => pin.join(".")).join(",") });
    look();
  }

  /** @param {number[]} pin */
  const named = (pin) =>
    along
      .map((name, i) => `${shown.called(name)} ${shown.value(name, selection.axes[name][pin[i]])}`)
      .join(", ");
  const here = () => along.map((name) => selection.place[name]);

  const look = debounced(PATIENCE_MILLISECONDS, async () => {
    const mine = ++asked;
    fill(
      list,
      pins.map((pin, i) =>
        el(
          "li",
          {},
          `${i + 1}: ${named(pin)} `,
          el(
            "button",
            {
              type: "button",
              class: "small",
              "aria-label": `Go to pin ${i + 1}`,
              onclick: () => selection.choose(Object.fromEntries(along.map((name, j) => [name, pin[j]]))),
            },
            "Go",
          ),
          " ",
          el(
            "button",
            {
              type: "button",
              class: "small",
              "aria-label": `Remove pin ${i + 1}`,
              onclick: () => keep(pins.filter((_, j) => j !== i)),
            },
            "Remove",
          ),
        ),
      ),
    );
    if ((selection.axes[FREQUENCY] ?? []).length < 2)
      return fill(
        trouble,
        el("p", { class: "quiet" }, "The study has one frequency, so there is no curve to compare."),
      );
    try {
      const path = studyPath(record.id, "frequency-response");
      const points = [here(), ...pins];
      const curves = await Promise.all(
        points.map((pin) =>
          ask(path, Object.fromEntries(along.map((name, i) => [name, selection.axes[name][pin[i]]]))),
        ),
      );
      if (mine !== asked || !trouble.isConnected) return;
      fill(trouble);
      await chart.draw(
        () =>
          curves.map((curve, i) => ({
            type: "scatter",
            mode: "lines",
            x: curve.frequency_ratio.map((r) => r * shown.factor(FREQUENCY)),
            y: curve.values.map((value) => (value === null ? null : value * shown.factor("amplitude_ratio"))),
            name: i === 0 ? "this point" : `pin ${i}`,
            line: { color: CURVES()[i], dash: DASHES[i], width: i === 0 ? 2.5 : 1.8 },
          })),
        () => ({
          xaxis: { title: { text: shown.axis(FREQUENCY) } },
          yaxis: {
            title: { text: shown.variable("amplitude_ratio", curves[0].long_name) },
            rangemode: "tozero",
          },
        }),
      );
    } catch (error) {
      if (mine === asked) fill(trouble, refusalBox(error));
    }
  });

  const pin = () => {
    const now = here();
    if (!pins.some((one) => one.join() === now.join())) keep([...pins, now].slice(-MOST));
  };
  selection.addEventListener("chosen", look);
  const element = el(
    "section",
    { class: "box" },
    el("h2", {}, "Pinned points"),
    el(
      "div",
      { class: "row controls" },
      el("button", { type: "button", onclick: pin }, "Pin this point"),
      el("span", { class: "quiet" }, `At most ${MOST}; the oldest is removed.`),
    ),
    list,
    trouble,
    chart.element,
  );
  return { element, look };
}
