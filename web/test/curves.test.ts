// Figures of messages that are plotted: chosen by port, row and field, and held in bounded memory.
import assert from "node:assert/strict";
import { test } from "node:test";
import type { CurveValues } from "../src/messages/messages.ts";
import { linesOf, precise } from "../src/plots/chart.ts";
import { Curves, MOST, MOST_POINTS, nameOf, unitOf } from "../src/plots/curves.ts";
import { KEPT_MS } from "../src/plots/history.ts";

const Z = { port: "track.tracks", row: "red", field: "z" };
const values = (value: number | null, field = "z"): CurveValues => ({
  type: "curves",
  port: "track.tracks",
  time: 0,
  values: [["red", field, value]],
});

test("a figure is named as its port, row and field, and has the unit of its type", () => {
  const figures = {
    ports: { "track.tracks": "Tracks" },
    kinds: { Tracks: { fields: [{ name: "z", unit: "m" }], rows: "target" as const } },
  };
  assert.equal(nameOf(Z), "track.tracks[red].z");
  assert.equal(nameOf({ port: "meter.out", row: "", field: "gain" }), "meter.out.gain");
  assert.equal(unitOf(Z, figures), "m");
  assert.equal(unitOf({ ...Z, port: "gone.out" }, figures), "");
});

test("the values of a chosen figure become its line, and nothing else", () => {
  const curves = new Curves();
  assert.ok(curves.add(Z));
  assert.ok(!curves.add({ ...Z })); // it is there already
  curves.take(0, values(1.5));
  curves.take(50, values(9)); // faster than a line is drawn
  curves.take(200, values(null));
  curves.take(400, values(7, "x")); // chosen by another browser
  assert.deepEqual(curves.points(Z, 400), [
    { time: 0, value: 1.5 },
    { time: 200, value: null },
  ]);
  curves.remove(Z);
  curves.take(600, values(1));
  assert.deepEqual(curves.points(Z, 600), []);
});

test("lines and their number have limits", () => {
  const curves = new Curves();
  curves.add(Z);
  for (let i = 0; i < MOST_POINTS + 500; i++) curves.take(100 * i, values(i));
  const now = 100 * (MOST_POINTS + 499);
  const points = curves.points(Z, now);
  assert.ok(points.length <= MOST_POINTS && points[0].time >= now - KEPT_MS);
  for (let i = 1; i < MOST; i++) assert.ok(curves.add({ ...Z, row: `${i}` }));
  assert.ok(!curves.add({ ...Z, row: "one more" }));
  assert.equal(curves.chosen.length, MOST);
});

test("a line may run below zero, and few digits tell a number of any size", () => {
  const points = [-1, 1].map((value, i) => ({ time: 1000 * i, value }));
  assert.deepEqual(linesOf(points, 1000, 1000, 1, -1), ["0.0,70.0 300.0,0.0"]);
  assert.deepEqual([-0.012345, 12345.6, 3, null].map(precise), ["−0.01235", "12350", "3", "–"]);
});
