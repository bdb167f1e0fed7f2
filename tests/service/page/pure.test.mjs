/** Modules of the page that need no browser, by node's own test runner. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { extentOf, isWide } from "../../../service/page/numbers.js";
import { tableOf } from "../../../service/page/figure_table.js";
import { History } from "../../../service/page/history.js";
import { doubt, parts, SEMICOLON } from "../../../service/page/lists.js";
import { Kept, plainly } from "../../../service/page/kept.js";
import { count, counted, drawn, duration, isLogarithmic, nearest, short, size } from "../../../service/page/numbers.js";
import { Selection } from "../../../service/page/selection.js";

// what modules of figures ask of a browser as they are loaded
globalThis.window = { matchMedia: () => ({ matches: false, addEventListener() {} }) };
globalThis.document = { documentElement: {}, baseURI: "http://localhost/" };
const { worded } = await import("../../../service/page/faults.js");
const { compiling } = await import("../../../service/page/patience.js");

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
