/** Shows the frequency responses of pinned points and of the selected point in one figure. */
/** @import { Curve, Session } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { box, button, debounced, el, fill, quiet, smallButton } from "./dom.js";
import { CURVES, DASHES, Figure } from "./figure.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { times } from "./shown.js";

const PATIENCE_MILLISECONDS = 200;
/** Largest number of pins, and number of line styles for their curves. */
const MOST = 4;

export class PinsPanel {
  list = el("ul", { class: "plain" });
  trouble = el("div");
  asked = 0;

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    const { selection, record } = session;
    this.along = selection.varied.filter((name) => name !== FREQUENCY);
    this.chart = new Figure({
      label: "Frequency responses of the point and of pinned points",
      name: `pinned-${record.id}`,
      height: 300,
      python: () => pythonLine(record.id, "frequency_response", selection.at([FREQUENCY])),
    });
    this.pins = this.readPins();
    this.look = debounced(PATIENCE_MILLISECONDS, () => this.draw());
    selection.addEventListener("chosen", this.look);
    this.element = box(
      "Pinned points",
      el(
        "div",
        { class: "row controls" },
        button("Pin this point", () => this.pin()),
        el("span", { class: "quiet" }, `At most ${MOST}; the oldest is removed.`),
      ),
      this.list,
      this.trouble,
      this.chart.element,
    );
  }

  /** Grid indices of the pins in the address; pins outside the study are ignored. @returns {number[][]} */
  readPins() {
    const { kept, selection } = this.session;
    const texts = (kept.values.pins ?? "").split(",").filter(Boolean);
    const lies = (/** @type {number} */ place, /** @type {number} */ i) =>
      Number.isInteger(place) && place >= 0 && place < selection.axes[this.along[i]].length;
    return texts
      .map((text) => text.split(".").map(Number))
      .filter((pin) => pin.length === this.along.length && pin.every(lies))
      .slice(0, MOST);
  }

  pin() {
    const now = this.here();
    if (!this.pins.some((one) => one.join() === now.join())) this.keep([...this.pins, now].slice(-MOST));
  }

  here() {
    return this.along.map((name) => this.session.selection.place[name]);
  }

  /** @param {number[][]} now */
  keep(now) {
    this.pins = now;
    this.session.kept.keep({ pins: now.map((pin) => pin.join(".")).join(",") });
    this.look();
  }

  /** A pin in the list, with buttons to select or remove the pin. @param {number[]} pin @param {number} i */
  item(pin, i) {
    const { selection, shown } = this.session;
    const words = this.along.map(
      (name, j) => `${shown.called(name)} ${shown.value(name, selection.axes[name][pin[j]])}`,
    );
    const go = () => selection.choose(Object.fromEntries(this.along.map((name, j) => [name, pin[j]])));
    const remove = () => this.keep(this.pins.filter((_, j) => j !== i));
    const buttons = [
      smallButton("Go", go, `Go to pin ${i + 1}`),
      " ",
      smallButton("Remove", remove, `Remove pin ${i + 1}`),
    ];
    return el("li", {}, `${i + 1}: ${words.join(", ")} `, buttons);
  }

  async draw() {
    const mine = ++this.asked;
    const { pins, along, list, trouble } = this;
    const { selection, record } = this.session;
    fill(
      list,
      pins.map((pin, i) => this.item(pin, i)),
    );
    if ((selection.axes[FREQUENCY] ?? []).length < 2)
      return fill(trouble, quiet("The study has one frequency, so there is no curve to compare."));
    try {
      const path = studyPath(record.id, "frequency-response");
      const at = (/** @type {number[]} */ pin) =>
        Object.fromEntries(along.map((name, i) => [name, selection.axes[name][pin[i]]]));
      const curves = await Promise.all([this.here(), ...pins].map((pin) => ask(path, at(pin))));
      if (mine !== this.asked || !trouble.isConnected) return;
      fill(trouble);
      await this.drawCurves(curves);
    } catch (error) {
      if (mine === this.asked) fill(trouble, refusalBox(error));
    }
  }

  /** @param {Curve[]} curves curve of the selected point, followed by the curves of the pins */
  async drawCurves(curves) {
    const { shown } = this.session;
    await this.chart.draw(
      () =>
        curves.map(({ frequency_ratio, values }, i) => ({
          type: "scatter",
          mode: "lines",
          x: times(frequency_ratio, shown.factor(FREQUENCY)),
          y: times(values, shown.factor("amplitude_ratio")),
          name: i === 0 ? "this point" : `pin ${i}`,
          line: { color: CURVES()[i], dash: DASHES[i], width: i === 0 ? 2.5 : 1.8 },
        })),
      () => ({
        xaxis: { title: shown.axis(FREQUENCY) },
        yaxis: { title: shown.variable("amplitude_ratio", curves[0].long_name), rangemode: "tozero" },
      }),
    );
  }
}
