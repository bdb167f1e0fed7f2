/** The map of a study with everything that chooses what it shows, and the point beside it. */
/** @import { Kept, MapAnswer, Marked, Shown, Tab } from "./types.js" */

import { ask, refusalBox, studyPath } from "./api.js";
import { axisPickers } from "./axis_pickers.js";
import { designs, NOTHING_FOUND } from "./designs.js";
import { checkbox, el, fill, picker, prose } from "./dom.js";
import { figure } from "./figure.js";
import { headline } from "./headline.js";
import { lineLayout, lineTraces, mapLayout, mapTraces } from "./map_figure.js";
import { pointPanel } from "./point.js";
import { pythonLine } from "./python_line.js";
import { FREQUENCY } from "./selection.js";
import { sliders } from "./sliders.js";
import { DIMENSIONS } from "./vocabulary.js";
import { WORDS } from "./words.js";

/** Values along either axis that are asked for: about as many as a screen tells apart. */
const MOST = 240;
const PATIENCE_MILLISECONDS = 1500;
const USUAL_METRIC = "amplitude_ratio";

/** @type {Tab} */
export function mapTab(session, place) {
  const { selection, record } = session;
  const { kept, shown } = session;
  const [x, y] = usualAxes(selection.varied);
  const view = { ...keptAxes(kept, selection.varied, x, y), ...keptLook(kept, session.variables) };
  /** @type {MapAnswer | null} */
  let map = null;
  let found = NOTHING_FOUND;
  let asked = 0;

  const map_ = figure({
    label: `Resonance map of ${record.name || record.id}`,
    name: `map-${record.id}`,
    height: 460,
    keyboard: "Arrow keys move the point",
    python: () => pythonLine(record.id, "resonance_map", whole()),
    clicked: (at) => {
      const [atX, atY] = [at.x / shown.factor(view.x), at.y / shown.factor(view.y)];
      selection.chooseValues({ [view.x]: atX, ...(map?.y.length === 1 ? {} : { [view.y]: atY }) });
    },
    zoomed: (change) => zoomed(change),
  });
  const note = el("p", { class: "quiet note" });
  const trouble = el("div");
  const head = el("div");
  const controls = el("div", { class: "row controls" });

  function drawControls() {
    const options =
      selection.varied.length > 1 ? selection.varied : DIMENSIONS.filter((name) => name === x || name === y);
    const names = /** @type {[string, string][]} */ (options.map((name) => [name, shown.title(name)]));
    const metrics = session.words.variables.filter((v) => session.variables.includes(v.name));
    fill(
      controls,
      axisPickers(names, view, () => (drawControls(), change({ window: {} }))),
      picker(
        "Shown",
        metrics.map((v) => [v.name, shown.variable(v.name, v.long_name)]),
        view.metric,
        (metric) => change({ metric }),
      ),
      checkbox(
        "Contour lines",
        view.contours,
        (contours) => (Object.assign(view, { contours }), keep(), draw()),
      ),
      checkbox(
        "Response classes",
        view.classes,
        (classes) => (Object.assign(view, { classes }), keep(), draw()),
      ),
    );
  }

  /** @param {Partial<typeof view>} what */
  function change(what) {
    Object.assign(view, what);
    keep();
    look();
  }

  /** Keep what differs from the usual view. */
  function keep() {
    const usual = view.x === x && view.y === y;
    kept.keep({
      x: usual ? null : view.x,
      y: usual ? null : view.y,
      metric: view.metric === USUAL_METRIC ? null : view.metric,
      contours: view.contours ? null : false,
      classes: view.classes || null,
      x_range: view.window.x_range,
      y_range: view.window.y_range,
    });
  }

  /**
   * What the map is asked for: the other dimensions at the point, the frequency open where the worst counts.
   */
  function whole() {
    const except = [view.x, view.y, ...(selection.worst ? [FREQUENCY] : [])];
    return { x: view.x, y: view.y, metric: view.metric, ...selection.at(except) };
  }

  /** The same as the screen can show it. */
  function question() {
    return { ...whole(), most: MOST, ...view.window };
  }

  let last = "";
  async function look() {
    const mine = ++asked;
    const parameters = question();
    last = JSON.stringify(parameters);
    try {
      const answer = await ask(studyPath(record.id, "resonance-map"), parameters);
      if (mine !== asked) return;
      map = shown.map(answer);
      fill(trouble);
      fill(note, prose(said(answer, shown)));
      await draw();
    } catch (error) {
      if (mine === asked) fill(trouble, refusalBox(error));
    }
  }

  async function draw() {
    if (!map) return;
    const current = map;
    if (current.y.length === 1)
      await map_.draw(
        () => lineTraces(current),
        () => lineLayout(current),
      );
    else
      await map_.draw(
        () => mapTraces(current, view, marks(), session.words),
        () => mapLayout(current),
      );
  }

  /** What is marked: what lies in this map, not what lies beside it. */
  function marks() {
    const judged = view.x !== FREQUENCY && view.y !== FREQUENCY;
    const here = (/** @type {Marked} */ design) =>
      judged &&
      selection.varied.every(
        (name) => [view.x, view.y, FREQUENCY].includes(name) || design[name] === selection.value(name),
      );
    const mark = (/** @type {Marked} */ design) => ({
      x: design[view.x] * shown.factor(view.x),
      y: design[view.y] * shown.factor(view.y),
      text: design.text,
    });
    return {
      best: found.best && here(found.best) ? { ...mark(found.best), acts: found.idle !== null } : null,
      idle: found.idle && here(found.idle) ? mark(found.idle) : null,
      pareto: found.pareto.filter(here).map(mark),
      point: selection.chosen
        ? {
            x: selection.value(view.x) * shown.factor(view.x),
            y: selection.value(view.y) * shown.factor(view.y),
          }
        : null,
    };
  }

  /**
   * What is looked at more closely is kept in the address, and asked for again: a map that was thinned shows
   * more there.
   *
   * @param {Record<string, unknown>} event
   */
  function zoomed(event) {
    if (event["xaxis.autorange"] && view.window.x_range) change({ window: {} });
    else if (event["xaxis.range[0]"] !== undefined || event["yaxis.range[0]"] !== undefined) {
      // kept in ratios, so that an address means the same to who looks at units
      const span = (/** @type {"x" | "y"} */ axis) => {
        const { type, range = [] } = map_.plot.layout[`${axis}axis`] ?? {};
        return range
          .map((end) => (type === "log" ? 10 ** end : end) / shown.factor(view[axis]))
          .sort((a, b) => a - b)
          .join(",");
      };
      change({ window: { x_range: span("x"), y_range: span("y") } });
    }
  }

  map_.plot.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    const steps = /** @type {Record<string, [string, number]>} */ ({
      ArrowLeft: [view.x, -1],
      ArrowRight: [view.x, 1],
      ArrowDown: [view.y, -1],
      ArrowUp: [view.y, 1],
    });
    const step = steps[event.key];
    if (!step) return;
    event.preventDefault();
    selection.choose({ [step[0]]: selection.place[step[0]] + step[1] });
  });

  selection.addEventListener("chosen", () => (JSON.stringify(question()) === last ? draw() : look()));
  session.changes.addEventListener(
    "grown",
    throttled(PATIENCE_MILLISECONDS, () => place.isConnected && look()),
  );

  drawControls();
  const ranking = designs(session, (now) => {
    found = now;
    fill(head, now.ranked && headline(session, now.ranked));
    draw();
  });
  fill(
    place,
    el(
      "div",
      { class: "study" },
      el(
        "div",
        { class: "left" },
        head,
        controls,
        trouble,
        map_.element,
        note,
        sliders(selection, session.shown),
      ),
      pointPanel(session, () => found.best),
      ranking,
    ),
  );
  look();
}

/**
 * The axes that were kept, where they are two different ones of the study.
 *
 * @param {Kept} kept @param {string[]} varied @param {string} x @param {string} y
 */
function keptAxes(kept, varied, x, y) {
  const asked = { x: kept.one("x", varied, x), y: kept.one("y", varied, y) };
  return asked.x === asked.y ? { x, y } : asked;
}

/** What else of a map was kept. @param {Kept} kept @param {string[]} variables */
function keptLook(kept, variables) {
  const { x_range, y_range } = kept.values;
  const span = /^[-+.\de]+,[-+.\de]+$/;
  return {
    metric: kept.one("metric", variables, USUAL_METRIC),
    contours: kept.on("contours", true),
    classes: kept.on("classes", false),
    /** @type {Record<string, string | undefined>} */
    window: span.test(x_range) && span.test(y_range) ? { x_range, y_range } : {},
  };
}

/** @param {string[]} varied @returns {[string, string]} */
function usualAxes(varied) {
  const order = WORDS.axes.filter((name) => varied.includes(name));
  const rest = WORDS.axes.filter((name) => !order.includes(name));
  const [x, y] = [...order, ...rest];
  return [x, y];
}

/** @param {MapAnswer} answer @param {Shown} shown */
function said(answer, shown) {
  const share = answer.complete < 1 ? `${Math.floor(100 * answer.complete)} % of this map is computed. ` : "";
  const failed = answer.points_failed ? `${answer.points_failed} points failed. ` : "";
  return share + failed + shown.words(answer).note;
}

/** At most once in a while, and once more at the end. @param {number} milliseconds @param {() => void} run */
function throttled(milliseconds, run) {
  let waiting = false;
  let again = false;
  const go = () => {
    if (waiting) {
      again = true;
      return;
    }
    run();
    waiting = true;
    setTimeout(() => {
      waiting = false;
      if (again) {
        again = false;
        go();
      }
    }, milliseconds);
  };
  return go;
}
