/** Modules of the page that need no browser, by node's own test runner. */

import assert from "node:assert/strict";
import { test } from "node:test";

// the modules as the service sends them; and what some ask of a browser as they are loaded
const module = (name) => import(`file://${process.env.PAGE}/${name}.js`);
globalThis.window = { matchMedia: () => ({ matches: false, addEventListener() {} }) };
globalThis.document = { documentElement: {}, baseURI: "http://localhost/" };
globalThis.IntersectionObserver = class {};
globalThis.getComputedStyle = () => ({ getPropertyValue: () => "" });
const { count, counted, drawn, duration, extentOf, isLogarithmic, isWide, nearest, short, size } = await module("numbers");
const { tableOf } = await module("figure_table");
const { History } = await module("history");
const { doubt, parts, SEMICOLON } = await module("lists");
const { Kept, plainly } = await module("kept");
const { mapTraces } = await module("map_figure");
const { Selection } = await module("selection");
const { cavityOf, inRatios, inUnits } = await module("quantities");
const { worded } = await module("faults");
const { compiling } = await module("patience");
const { isComparable } = await module("vocabulary");
const { bestOf } = await module("best");
const { isStoredAlready } = await module("document_form");

test("numbers have the digits that matter, times and sizes the unit that is read", () => {
  const shown = [[1.23456789, "1.2346"], [0, "0"], [12345678, "1.23e7"], [0.000012, "1.20e-5"], [null, "–"], [NaN, "–"]];
  for (const [value, text] of shown) assert.equal(short(value), text);
  const times = [[2e-5, "20 µs"], [0.25, "250 ms"], [59, "59 s"], [120, "2 min"], [3600, "60 min"], [7200, "2 h"], [2 * 86400, "2 days"], [null, "–"]];
  for (const [seconds, text] of times) assert.equal(duration(seconds), text);
  for (const [bytes, text] of [[999, "999 bytes"], [1500, "1.5 kB"], [2e9, "2 GB"]]) assert.equal(size(bytes), text);
  for (const [units, text] of [["m", "2.13 mm"], ["m/s", "2.13 mm/s"], ["m/s²", "0.00213 m/s²"]]) assert.equal(drawn(0.0021349, units, 3), text);
  assert.equal(count(1234567), "1,234,567");
  assert.deepEqual([counted(1, "point"), counted(2, "point")], ["1 point", "2 points"]);
});

test("who waits for kernels is told how many there are", () => {
  assert.equal(compiling({ phase_done: 1, phase_total: 3 }), "Compiling kernels, 1 of 3 scenes done …");
});

test("places on axes", () => {
  assert.equal(nearest([1, 2, 4], 3.1), 2);
  assert.equal(isLogarithmic([1, 10, 100]), true);
  assert.equal(isLogarithmic([1, 2, 3]), false);
  assert.equal(plainly([8.999999999999998, 10], 0), "9");
  assert.equal(plainly([1.0001, 1.0002], 0), "1.0001");
});

test("how far values reach", () => {
  assert.deepEqual(extentOf([[3, null], [1, 2]]), [1, 3]);
  assert.deepEqual(extentOf([[null]]), [NaN, NaN]);
  assert.deepEqual([isWide([1, 21]), isWide([1, 19]), isWide([0, 21])], [true, false, false]);
});

test("a figure as a table", () => {
  const axis = (text) => ({ title: { text } });
  const map = { type: "heatmap", x: [1, 2], y: [3], z: [[Math.log10(5), null]], customdata: [[5, null]], colorbar: { title: { text: "X/Z" } } };
  assert.equal(tableOf([map], { xaxis: axis("d/Z"), yaxis: axis("γ<sub>F</sub>") }), "d/Z,γF,X/Z\n1,3,5\n2,3,\n");
  const curve = { name: "a, b", x: [0.1 + 0.2], y: [7] };
  assert.equal(tableOf([curve], { xaxis: axis("r"), yaxis: axis("X/Z") }), 'curve,r,value,what\n"a, b",0.3,7,X/Z\n');
});

test("a motion: base, cavity, and strobes", () => {
  const [samples, r] = [1024, 0.5]; // two cycles
  const phase = Array.from({ length: samples + 1 }, (_, k) => (4 * Math.PI * k) / samples);
  const u = phase.map((a) => 2 * Math.sin(a) + 0.5 * Math.sin(3 * a));
  const zero = phase.map(() => 0);
  const motion = new History(
    { time: phase.map((a) => a / r), u, u_rate: zero, v: phase.map((a, i) => u[i] - Math.sin(a)), v_rate: zero, p: u.map((x) => x + 1), p_rate: zero, impact: phase.map((_, i) => Number(i === 7)) },
    r,
  );
  const near = (found, wanted) => assert.ok(Math.abs(found - wanted) < 1e-3, `${found} is not ${wanted}`);
  assert.equal(motion.length, 2);
  near(motion.base(0.25), 1);
  near(motion.inCavity[5], 1);
  assert.deepEqual(motion.impacts, [7]);
  assert.equal(motion.strobes.u.length, 2);
});

test("the point of a study that is looked at", () => {
  const chosen = new Selection({ clearance_ratio: [1, 2, 5], friction_ratio: [0.1], frequency_ratio: [0.8, 1.05, 1.3] });
  assert.deepEqual([chosen.varied, chosen.value("frequency_ratio"), chosen.worst], [["clearance_ratio", "frequency_ratio"], 1.05, true]);
  chosen.rest({ clearance_ratio: 5 });
  assert.equal(chosen.value("clearance_ratio"), 5);
  chosen.chooseValues({ clearance_ratio: 1.9 });
  chosen.rest({ clearance_ratio: 5 }); // whoever has chosen stays there
  assert.deepEqual(chosen.at(["frequency_ratio"]), { clearance_ratio: 2 });
  chosen.choose({ clearance_ratio: 99 });
  assert.equal(chosen.value("clearance_ratio"), 5);
});

test("what is kept in an address is taken where it may be", () => {
  const kept = new Kept("#/a", new URLSearchParams("x=2&on=no&which=odd"));
  assert.deepEqual([kept.number("x", 0, 5, 1), kept.number("x", 3, 5, 4), kept.number("y", 0, 5, 1)], [2, 4, 1]);
  assert.deepEqual([kept.on("on", true), kept.one("which", ["a", "b"], "b")], [false, "b"]);
  assert.equal(kept.at("#/b"), "#/b?x=2&on=no&which=odd");
});

test("a comma between two digits is asked about, not split", () => {
  const lists = [["0.2, 0.5", ["0.2", "0.5"]], ["1,2,3", ["1", "2", "3"]], ["0.2,0.5;1 2", ["0.2", "0.5", "1", "2"]], ["0,2", ["0,2"]], ["0,2; 0,5", ["0,2", "0,5"]], ["", []]];
  for (const [text, found] of lists) assert.deepEqual(parts(text), found);
  for (const plain of ["0.2, 0.5", "1,2,3", "1 2", "x"]) assert.equal(doubt(plain), null);
  assert.deepEqual(doubt("0,2 1"), { question: "Is 0,2 the number 0.2, or 0 and 2?", decimal: "0.2, 1", list: "0, 2, 1" });
  const named = "soft rubber 0,3, steel 0.8";
  assert.deepEqual(parts(named, SEMICOLON), ["soft rubber 0,3", "steel 0.8"]);
  assert.equal(doubt(named, SEMICOLON).decimal, "soft rubber 0.3, steel 0.8");
});

test("a fault is said in the words and the unit of its field", () => {
  const fault = { field: "tolerances.clearance_m", found: "0.5", allowed: "at most 0.00075", advice: "work closer, or write 10%", message: "`tolerances.clearance_m` = 0.5 is too much." };
  const looks = { label: "tolerance of the clearance d", unit: "mm", scale: "1000" };
  assert.equal(worded(fault, looks), "Tolerance of the clearance d [mm]: allowed is at most 0.75, not 500. Work closer, or write 10%.");
  const text = { ...fault, found: 'the text "0,5"', advice: "give it in m" };
  assert.equal(worded(text, looks), 'Tolerance of the clearance d [mm]: allowed is at most 0.75, not the text "0,5".');
  const ratio = { field: "axes.mass_ratio", found: "-1", allowed: "a number from 0 to 1", advice: "", message: "`axes.mass_ratio` must be a number from 0 to 1, not -1." };
  assert.equal(worded(ratio, { label: "Mass ratio β" }), "Mass ratio β must be a number from 0 to 1, not -1.");
  assert.equal(worded(ratio, {}), "`axes.mass_ratio` must be a number from 0 to 1, not -1.");
});

test("a fault of a range is told by the titles of its fields", () => {
  const swapped = { field: "axes.frequency_ratio.stop", found: "7", allowed: "greater than start (11)", advice: "exchange start and stop", message: "`axes.frequency_ratio.stop` must be greater than start (11), not 7." };
  assert.equal(worded(swapped, { label: "Frequency r" }), "Frequency r must be greater than “from” (11), not 7. Exchange “from” and “to”.");
  const left = { field: "axes.mass_ratio.num", found: "nothing", allowed: "a number", advice: "add `num`", message: "`start.n` stays." };
  assert.equal(worded(left, { label: "Mass ratio" }), "`start.n` stays. Add “values”.");
});

test("studies that the service can compare are offered", () => {
  const plain = { dimensions: ["damping_ratio", "clearance_ratio", "frequency_ratio"], shape: [1, 9, 41] };
  const rubbing = { dimensions: ["particle_friction_ratio", ...plain.dimensions], shape: [1, ...plain.shape] };
  assert.equal(isComparable(plain, rubbing, ["clearance_ratio", "damping_ratio", "frequency_ratio"]), true);
  const fewer = { ...rubbing, shape: [1, 1, 9, 21] };
  assert.equal(isComparable(plain, fewer, ["clearance_ratio", "frequency_ratio"]), false);
  assert.equal(isComparable(plain, fewer, ["clearance_ratio", "damping_ratio"]), true);
  assert.equal(isComparable(plain, { dimensions: ["record", "scale"], shape: [9, 41] }, []), false);
});

test("a name that is not kept is told", () => {
  assert.deepEqual([["own", "own"], ["own", " own "], ["own", ""], ["own", undefined], ["own", "new"], ["", "new"]].map((each) => isStoredAlready(...each)), [false, false, false, false, true, true]);
});

test("contour lines lie within the values of a map, few of them, and none where values are equal but for rounding", () => {
  let state = 5; // of a generator of Lehmer's
  const random = () => (state = (16807 * state) % 2147483647) / 2147483647;
  const levelsOf = (values) => {
    const map = { x: [1, 2, 3, 4, 5, 6, 7], y: [1, 2, 3, 4, 5, 6], values, metric: "amplitude_ratio", long_name: "X/Z", meanings: {} };
    const traces = mapTraces(map, { contours: true, classes: false }, { best: null, other: null, pareto: [], point: null }, { variables: [], response_class: {} });
    return traces.find(({ type }) => type === "contour")?.contours ?? null;
  };
  const map = (value) => Array.from({ length: 6 }, () => Array.from({ length: 7 }, value));
  assert.deepEqual([levelsOf(map(() => null)), levelsOf(map(() => 1))], [null, null]);
  let drawn = 0;
  for (let tried = 0; tried < 81; tried += 1) {
    const [scale, spread, share] = [10 ** (6 * random() - 3), 10 ** -(2 * (tried % 9)), [0.05, 0.3, 1][Math.floor(tried / 27)]];
    const values = map(() => (random() < share ? scale * (1 + spread * Math.floor(4 * random())) : null));
    const levels = levelsOf(values);
    let [low, high] = extentOf(values);
    if (isWide([low, high])) [low, high] = [Math.log10(low), Math.log10(high)];
    if (!(high - low > 1e-9 * Math.max(Math.abs(low), Math.abs(high)))) assert.equal(levels, null);
    if (levels === null) continue;
    drawn += 1;
    const lines = Math.round((levels.end - levels.start) / levels.size) + 1;
    assert.ok(1 <= lines && lines <= 12 && low < levels.start && levels.start <= levels.end && levels.end < high, JSON.stringify(levels));
  }
  assert.ok(drawn > 10);
});

test("ratios turned into units and back, and a cavity that stands", () => {
  const near = (found, wanted) => assert.ok(Math.abs(found / wanted - 1) < 1e-12, `${found} is not ${wanted}`);
  const study = { axes: { clearance_ratio: { start: 1, stop: 25, num: 49 }, restitution: 0.47 } };
  const structure = { natural_frequency_hz: 2.5, base_amplitude_m: 0.0015 };
  const sized = inUnits({ ...study, physical: structure });
  assert.deepEqual([sized.physical.clearance_m, sized.axes], [{ start: 0.0015, stop: 0.0375, num: 49 }, { restitution: 0.47 }]);
  assert.deepEqual(inRatios(sized), study);
  assert.equal(inUnits({ axes: { friction_ratio: 0.8 } }).physical.friction_force_n, 0.475); // of the first structure
  const standing = inRatios({ ...study, physical: { ...structure, particle_friction_coefficient: 0.02, tilt_deg: 90 } });
  assert.equal(standing.particle_friction_ratio, 0); // a particle that stands on its wall rubs on nothing
  near(standing.gravity_ratio, 9.80665 / ((2 * Math.PI * 2.5) ** 2 * 0.0015));
  // of a tilt that is an axis the point of a study has one value
  const point = { definition: { physical: { tilt_deg: [0, 30] } }, dimensions: ["gravity_ratio", "particle_friction_ratio"] };
  const weight = standing.gravity_ratio;
  const ratios = { gravity_ratio: weight / 2, particle_friction_ratio: 0.02 * weight * Math.cos(Math.PI / 6) };
  const lies = cavityOf(point, (ratio) => ratios[ratio], structure);
  near(lies.particle_friction_coefficient, 0.02);
  near(lies.tilt_deg, 30);
  assert.equal(cavityOf({ ...point, dimensions: [] }, () => NaN, structure).particle_friction_coefficient, 0);
});

test("values of a list are requested in turn, and not any more once the list was left", async () => {
  const asked = [];
  globalThis.fetch = (url, { signal }) =>
    new Promise((_, stop) => {
      asked.push(url.pathname.split("/")[4]);
      if (signal.aborted) stop(signal.reason);
      signal.addEventListener("abort", () => stop(signal.reason));
    });
  const study = (id) => ({ id, revision: 1, points_done: 4, points_total: 4 });
  const list = () => {
    const leaving = new AbortController();
    return [leaving, Promise.all(["a", "b", "c"].map((id) => bestOf(study(id), leaving.signal)))];
  };
  for (let visit = 0; visit < 2; visit += 1) {
    const [leaving, bests] = list();
    assert.deepEqual(asked.splice(0), ["a", "a"]); // its ranking and its units
    leaving.abort();
    assert.deepEqual(await bests, [null, null, null]);
    asked.length = 0;
  }
});
