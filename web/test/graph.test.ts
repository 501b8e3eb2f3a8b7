import assert from "node:assert/strict";
import { test } from "node:test";
import { labelOf, linksOf } from "../src/graph/links.ts";
import { standings, steps } from "../src/graph/ranks.ts";
import { type Box, routed } from "../src/graph/routes.ts";
import { edge } from "./run.ts";

const BOX = { kind: "reference", delay: false };
const plan = [
  { from: "camera/cam0.out", to: "color/cam0.frame", ...BOX },
  { from: "camera/cam1.out", to: "color/cam1.frame", ...BOX },
  { from: "color/cam0.out", to: "fuse.blobs", ...BOX },
  { from: "track.forecast", to: "fuse.forecast", kind: "ring", delay: true },
];
const groupOf = (stage: string) => stage.split("/")[0];

test("branches beside each other have the same rank, and what leads back moves nothing", () => {
  const links: [string, string][] = [
    ["a", "b"],
    ["a", "c"],
    ["b", "d"],
    ["c", "d"],
    ["d", "b"],
    ["a", "d"],
  ];
  assert.deepEqual(Object.fromEntries(standings(["a", "b", "c", "d"], links)), {
    a: { rank: 0, row: 0 },
    b: { rank: 1, row: 0 },
    c: { rank: 1, row: 1 },
    d: { rank: 2, row: 0 },
  });
});

test("running downwards, an unfolded sub-graph has a step of its own", () => {
  const found = standings(
    ["a", "b", "c", "d"],
    [
      ["a", "d"],
      ["b", "d"],
    ],
  );
  const at = (wide: string[]) => Object.fromEntries(steps(found, new Set(wide)));
  assert.deepEqual(at([]).c, { step: 0, column: 2, alone: false });
  assert.deepEqual(at(["a"]), {
    b: { step: 0, column: 0, alone: false },
    c: { step: 0, column: 1, alone: false },
    a: { step: 1, column: 0, alone: true },
    d: { step: 2, column: 0, alone: true },
  });
});

test("edges between the instances of two cards are one link, with the worst of their figures", () => {
  const status = (from: string, to: string, but: object) => ({ ...edge("x", "y", but), from, to });
  const edges = [
    status("camera/cam0.out", "color/cam0.frame", { rate: 20, p95_ms: 4, dropped: 2 }),
    status("camera/cam1.out", "color/cam1.frame", { rate: 19, p95_ms: 80, late: 1 }),
  ];
  const links = linksOf(plan, edges, groupOf);
  assert.deepEqual(
    links.map(({ from, to, kind, delay }) => [from, to, kind, delay]),
    [
      ["camera", "color", "reference", false],
      ["color", "fuse", "reference", false],
      ["track", "fuse", "ring", true],
    ],
  );
  assert.deepEqual(labelOf(links[0]), { rate: "20.0/s", age: "80 ms", loss: "−3", old: false });
  assert.deepEqual(labelOf(links[1]), { rate: "", age: "", loss: "", old: false });
});

test("edges within one card are not drawn, and figures of absent hosts are called old", () => {
  assert.deepEqual(
    linksOf(plan, [], () => "all"),
    [],
  );
  const old = {
    from: "a",
    to: "b",
    kind: "zenoh",
    delay: false,
    edges: [edge("a", "b", { rate: null, old: true })],
  };
  assert.deepEqual(labelOf(old), { rate: "old", age: "", loss: "", old: true });
});

// Boxes of 10 x 10, at these columns and rows.
function boxes(places: Record<string, [number, number]>): Map<string, Box> {
  const at = ([u, v]: [number, number]): Box => ({
    u0: 50 * u,
    u1: 50 * u + 10,
    v0: 50 * v,
    v1: 50 * v + 10,
  });
  return new Map(Object.entries(places).map(([name, place]) => [name, at(place)]));
}

test("a line goes straight over, round what is in its way, and back behind all boxes", () => {
  const links = [
    { from: "a", to: "b" },
    { from: "a", to: "c" },
    { from: "c", to: "a" },
    { from: "c", to: "b" },
  ];
  const { routes, before, behind } = routed(boxes({ a: [0, 0], b: [1, 0], c: [2, 0] }), links);
  assert.deepEqual(routes[0].corners, [
    [10, 5],
    [50, 5],
  ]);
  const lane = (i: number) => routes[i].corners[2][1];
  assert.ok(lane(1) < 0 && before > -lane(1));
  assert.ok(lane(2) > 10 && behind > lane(2) - 10);
  assert.equal(lane(2), lane(3)); // from the same origin
  assert.deepEqual(routes[1].corners.at(-1)?.[0], 100);
});

test("a line passes beside a box that is not in its way, and no two labels stand at one place", () => {
  const links = [
    { from: "a", to: "c" },
    { from: "c", to: "a" },
    { from: "c", to: "b" },
  ];
  const { routes } = routed(boxes({ a: [0, 0], b: [0, 1], c: [2, 0], d: [1, 1] }), links);
  assert.equal(routes[0].corners.length, 2);
  assert.notDeepEqual(routes[1].label, routes[2].label);
});

test("labels of two lines in one lane stand one beyond the other, and the lane has room for both", () => {
  const places = boxes({ a: [0, 0], b: [0, 1], c: [1, 0.5], d: [2, 0.5] });
  const links = [
    { from: "d", to: "a" },
    { from: "d", to: "b" },
  ];
  const { routes, behind } = routed(places, links);
  const [first, second] = routes.map(({ label }) => label);
  assert.equal(first[0], second[0]);
  assert.ok(second[1] > first[1] && second[1] < 60 + behind);
  assert.ok(routed(places, links.slice(0, 1)).behind < behind);
});
