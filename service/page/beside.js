/** A study beside another one: the same map of both on one scale of colours, and the one less the other. */
/** @import { MapDifference, StudyRecord, Tab } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { axisPickers } from "./axis_pickers.js";
import { differenceTraces, sharedTraces, sideTraces } from "./beside_figure.js";
import { el, fill, picker, prose } from "./dom.js";
import { figure } from "./figure.js";
import { help } from "./help.js";
import { lineLayout, mapLayout } from "./map_figure.js";
import { measures, unitOf } from "./measures.js";
import { pythonLine } from "./python_line.js";
import { AMPLITUDE, FREQUENCY, RECORD } from "./selection.js";
import { sliders } from "./sliders.js";
import { WORDS } from "./words.js";

const MOST = 160;
/** Newest studies that are offered. */
const OFFERED = 200;

/** @type {Tab} */
export function besideTab(session, place) {
  const { selection, record, kept, shown } = session;
  const metrics = measures(session).filter((one) => !one.coded && session.variables.includes(one.name));
  const numeric = Object.keys(selection.axes).filter((name) => name !== RECORD);
  const varied = numeric.filter((name) => selection.axes[name].length > 1);
  const usual = [
    ...(RECORD in selection.axes
      ? WORDS.suite_axes
      : AMPLITUDE in selection.axes
        ? WORDS.amplitude_axes
        : WORDS.axes),
    ...numeric,
  ];
  const [x, y] = [...new Set([...usual.filter((name) => varied.includes(name)), ...usual])];
  const view = {
    x: kept.one("x", varied, x),
    y: kept.one("y", varied, y),
    metric: kept.one(
      "metric",
      metrics.map((one) => one.name),
      metrics[0].name,
    ),
    minus: kept.values.minus ?? "",
  };
  if (view.x === view.y) Object.assign(view, { x, y });
  /** @type {MapDifference | null} */
  let answer = null;
  /** @type {StudyRecord[]} */
  let others = [];
  let asked = 0;

  const named = (/** @type {string} */ name) => record.name || name;
  const charts = ["this study", "the other study", "this study less the other"].map((label, i) =>
    figure({
      label: `Map of ${label}`,
      name: `${["this", "other", "difference"][i]}-${record.id}`,
      height: 340,
      python: () =>
        pythonLine(
          i === 1 ? view.minus : record.id,
          "resonance_map",
          i === 2 ? question() : { ...question(), minus: null },
        ),
      clicked: (at) => {
        const [atX, atY] = [at.x / shown.factor(view.x), at.y / shown.factor(view.y)];
        selection.chooseValues({ [view.x]: atX, ...(answer?.y.length === 1 ? {} : { [view.y]: atY }) });
      },
    }),
  );
  const titles = charts.map(() => el("h3", {}));
  const controls = el("div", { class: "row controls" });
  const trouble = el("div");
  const note = el("p", { class: "note", role: "status" });
  const maps = el(
    "div",
    { class: "sides" },
    charts.map(({ element }, i) => el("div", {}, titles[i], element)),
  );

  function drawControls() {
    const names = /** @type {[string, string][]} */ (
      (varied.length > 1 ? varied : [x, y]).map((name) => [name, shown.title(name)])
    );
    const offered = /** @type {[string, string][]} */ (
      others.map((one) => [one.id, `${one.name || "(no name)"} · ${one.id}`])
    );
    if (view.minus && !others.some((one) => one.id === view.minus)) offered.unshift([view.minus, view.minus]);
    fill(
      controls,
      picker("Beside", [["", "choose a study"], ...offered], view.minus, (minus) => change({ minus })),
      axisPickers(names, view, () => (drawControls(), change({}))),
      picker(
        "Shown",
        metrics.map((one) => [one.name, shown.variable(one.name, unitOf(one))]),
        view.metric,
        (metric) => change({ metric }),
      ),
    );
  }

  /** @param {Partial<typeof view>} what */
  function change(what) {
    Object.assign(view, what);
    const first = view.x === x && view.y === y;
    kept.keep({
      minus: view.minus,
      x: first ? null : view.x,
      y: first ? null : view.y,
      metric: view.metric === metrics[0].name ? null : view.metric,
    });
    look();
  }

  /**
   * In SI units where the study is shown in units: either study is turned into them by its own structure.
   *
   */
  function question() {
    const open = [
      view.x,
      view.y,
      RECORD,
      AMPLITUDE,
      ...(RECORD in selection.axes ? ["scale"] : []),
      ...(selection.worst ? [FREQUENCY] : []),
    ];
    const at = Object.entries(selection.at(open)).map(([name, value]) => [
      shown.nameInSi(name),
      shown.inSi(name, value),
    ]);
    return {
      x: shown.nameInSi(view.x),
      y: shown.nameInSi(view.y),
      metric: shown.nameInSi(view.metric),
      ...Object.fromEntries(at),
      minus: view.minus,
    };
  }

  async function look() {
    const mine = ++asked;
    maps.hidden = !view.minus;
    if (!view.minus)
      return fill(
        note,
        others.length
          ? "Choose a study with the same axes."
          : "There is no other study of this kind yet. " +
              "Edit a copy of this one, change what you want to compare, and come back.",
      );
    try {
      const asked_ = { ...question(), most: MOST };
      const found = /** @type {MapDifference} */ (await ask(studyPath(record.id, "resonance-map"), asked_));
      if (mine !== asked) return;
      answer = shown.mapInSi(found, view);
      fill(trouble);
      fill(note, prose(shown.words(found).note));
      const other = others.find((one) => one.id === found.studies[1]);
      const texts = [
        named(record.id),
        other?.name || found.studies[1],
        `${named(record.id)} less ${other?.name || found.studies[1]}`,
      ];
      titles.forEach((title, i) => fill(title, texts[i]));
      await draw();
    } catch (error) {
      if (mine !== asked) return;
      maps.hidden = true;
      fill(note);
      fill(trouble, refusalBox(error));
    }
  }

  async function draw() {
    if (!answer) return;
    const now = answer;
    if (now.y.length === 1) {
      await charts[0].draw(
        () => sideTraces(now, ["this study", "the other study"]),
        () => lineLayout(now),
      );
      await charts[2].draw(
        () => [sideTraces({ ...now, values: now.difference }, ["difference"])[0]],
        () => lineLayout({ ...now, long_name: `difference, ${now.long_name}` }),
      );
      charts[1].element.parentElement?.toggleAttribute("hidden", true);
    } else {
      const point = selection.chosen
        ? {
            x: selection.value(view.x) * shown.factor(view.x),
            y: selection.value(view.y) * shown.factor(view.y),
          }
        : null;
      const [first, second] = [
        now,
        { ...now, values: now.other, status: now.other_status, response_class: now.other_response_class },
      ];
      await charts[0].draw(
        () => sharedTraces(first, second, point),
        () => mapLayout(now),
      );
      await charts[1].draw(
        () => sharedTraces(second, first, point),
        () => mapLayout(now),
      );
      await charts[2].draw(
        () => differenceTraces(now, point),
        () => mapLayout(now),
      );
    }
  }

  selection.addEventListener("chosen", () => place.isConnected && look());
  session.changes.addEventListener("grown", () => place.isConnected && look());
  fill(
    place,
    el(
      "section",
      { class: "box beside-study" },
      help("page/#compare-with-another-study", "two studies side by side"),
      el("h2", {}, "Compare with another study"),
      el(
        "p",
        { class: "quiet" },
        "The same map of two studies with the same axes, on one scale of colours, and the first less " +
          "the second: where it is below 0, this study’s value is the smaller one.",
      ),
      controls,
      trouble,
      note,
      maps,
      sliders(selection, shown),
    ),
  );
  async function offer() {
    try {
      const { studies } = await ask("studies", { limit: OFFERED });
      others = studies.filter(
        (one) => one.id !== record.id && one.dimensions.join() === record.dimensions.join(),
      );
      const meant = others.find(
        (one) => view.minus && (one.id.startsWith(view.minus) || one.name === view.minus),
      );
      if (meant) view.minus = meant.id;
    } catch (error) {
      fill(trouble, refusalBox(error));
    }
    drawControls();
    look();
  }
  void offer();
}
