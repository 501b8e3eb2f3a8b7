import assert from "node:assert/strict";
import { test } from "node:test";
import { linesOf, spanOf } from "../src/plots/chart.ts";
import { History, KEPT_MS, targetKey } from "../src/plots/history.ts";
import { columnsOf } from "../src/tiles/tiles.ts";
import { edge } from "./run.ts";

const run = (lost: number, but: object = {}) => ({
  rate: 20,
  stages: [],
  edges: [edge("a", "b", { dropped: lost, p95_ms: 7 })],
  paths: [],
  news: [] as string[],
  faults: [] as string[],
  ...but,
});
const members = new Map([["b", new Set(["b"])]]);

test("losses are told a second, and what is too long ago is forgotten", () => {
  const history = new History();
  history.take(0, run(0), members);
  history.take(500, run(3), members);
  history.take(501, run(9), members); // late, and at once
  history.take(1000, run(3), members);
  const values = (name: string) => history.points(name, "losses").map(({ value }) => value);
  assert.deepEqual(values(""), [6, 0]);
  assert.deepEqual(values("b"), [6, 0]);
  assert.deepEqual(
    history.points("b", "age").map(({ value }) => value),
    [7, 7, 7],
  );
  history.take(KEPT_MS + 800, run(3), members);
  assert.equal(history.points("", "rate").length, 2);
});

test("height, stated error and residual of a target are kept with the sample that follows", () => {
  const history = new History();
  const places = (z: number) => ({
    target: [1],
    xyz: [[0, 0, z] as [number, number, number]],
    sigma: [[0.1, 0.3, null]],
  });
  history.tracks(places(1));
  history.tracks(places(1.5));
  history.take(0, run(0), members, new Map([[1, 2.5]]));
  history.take(500, run(0), members); // nothing was told of it
  const values = (figure: "height" | "sigma" | "residual") =>
    history.points(targetKey(1), figure).map(({ value }) => value);
  assert.deepEqual(values("height"), [1.5, null]);
  assert.deepEqual(values("sigma"), [0.3, null]);
  assert.deepEqual(values("residual"), [2.5, null]);
});

test("faults are marked when they begin and end, however old they say they are, and news once", () => {
  const history = new History();
  history.take(0, run(0, { news: ["a worker is back"] }), members);
  history.take(500, run(0, { faults: ["host x: last heard 1 s ago"], news: ["a worker is back"] }), members);
  history.take(1000, run(0, { faults: ["host x: last heard 2 s ago"], news: ["b"] }), members);
  history.take(1500, run(0, { news: ["b"] }), members);
  assert.deepEqual(
    history.marks.map(({ time, text, fault }) => [time, text, fault]),
    [
      [0, "a worker is back", false],
      [500, "host x: last heard 1 s ago", true],
      [1000, "b", false],
      [1500, "over: host x: last heard 2 s ago", false],
    ],
  );
});

test("a line is broken where a value is missing", () => {
  const points = [0, 1, null, 1, 2].map((value, i) => ({ time: i * 1000, value }));
  const lines = linesOf(points, 4000, spanOf(points, 4000), 2);
  assert.equal(lines.length, 2);
  assert.ok(lines[1].endsWith("300.0,0.0"));
  assert.equal(spanOf(points, 4000), 60_000);
  assert.equal(spanOf(points, 100_000), 100_000);
  assert.equal(spanOf(points, 2 * KEPT_MS), KEPT_MS);
});

test("as few tiles beside each other as leave all in sight", () => {
  assert.equal(columnsOf(1, 4 / 3, 600, 100), 1);
  assert.equal(columnsOf(6, 4 / 3, 656, 546), 3);
  assert.equal(columnsOf(6, 4 / 3, 656, 800), 2);
  assert.equal(columnsOf(40, 4 / 3, 656, 500), 5);
});
