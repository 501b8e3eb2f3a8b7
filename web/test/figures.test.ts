import assert from "node:assert/strict";
import { test } from "node:test";
import { latenciesOf, rateOf } from "../src/graph/subgraph_card.ts";
import { doing, largest, lossOf, slowest, span } from "../src/words/figures.ts";
import { edge, stage } from "./run.ts";

const WITHIN = new Set(["z/a", "z/b"]);
const STAGES = [stage("z/a", { rate: 50 }), stage("z/b", { rate: 7 })];
const PATHS = [
  { origin: "z/a", sink: "z/b", p50_ms: 1, p95_ms: 5, old: false },
  { origin: "z/a", sink: "y", p50_ms: 1, p95_ms: 80, old: false },
];

test("the rate and the latency of a sub-graph are those of what leaves it", () => {
  const edges = [
    edge("z/a", "z/b", { rate: 50, p95_ms: 2 }),
    edge("z/a", "y", { rate: 20, p95_ms: 30 }),
    edge("z/a", "x", { rate: 9, p95_ms: null }),
  ];
  assert.equal(rateOf(WITHIN, STAGES, edges), 20);
  assert.equal(slowest(latenciesOf(WITHIN, { edges, paths: PATHS }))?.p95_ms, 30);
});

test("where nothing leaves it, those of its last stages", () => {
  const edges = [edge("z/a", "z/b", { rate: 50, p95_ms: 2 })];
  assert.equal(rateOf(WITHIN, STAGES, edges), 7);
  assert.equal(slowest(latenciesOf(WITHIN, { edges, paths: PATHS }))?.p95_ms, 5);
});

test("unknown figures count for nothing and old ones are left out", () => {
  assert.equal(largest([null, 3, null, 1]), 3);
  assert.equal(largest([null]), null);
  assert.equal(slowest([]), null);
  const edges = [edge("z/a", "y", { p95_ms: 30, old: true })];
  assert.deepEqual(latenciesOf(WITHIN, { edges, paths: [] }), []);
});

test("losses are all that was not delivered", () => {
  assert.equal(
    lossOf([edge("a", "b", { away: 1, dropped: 2 }), edge("b", "c", { late: 4, invalid: 8 })]),
    15,
  );
});

test("a latency is told in the unit that fits", () => {
  assert.equal(span({ p50_ms: 1, p95_ms: 5 }), "1.0 / 5.0 ms");
  assert.equal(span({ p50_ms: 90, p95_ms: 250 }), "90 / 250 ms");
  assert.equal(span({ p50_ms: 900, p95_ms: 2500 }), "0.9 / 2.5 s");
});

test("the worst of several instances is told, with how many and since when", () => {
  const absent = stage("a", { state: "absent", age_s: 12 });
  assert.equal(doing([absent, stage("b"), stage("c")]), "1 of 3 absent since 12 s");
  assert.equal(
    doing([stage("a", { state: "getting", idle_s: 1 }), stage("b", { state: "getting", idle_s: 9 })]),
    "waiting for input",
  );
});

test("a state is told in plain words", () => {
  const words = (but: Parameters<typeof stage>[1], source = false) => doing([stage("a", but)], source);
  assert.equal(words({ state: "getting", idle_s: 7 }), "waiting for input, 7 s");
  assert.equal(words({ state: "getting" }, true), "waiting for its device");
  assert.equal(words({ state: "waiting", on: ["b"] }), "waiting for its turn");
  assert.equal(words({ state: "processing" }), "working");
  assert.equal(words({ state: "sending", on: ["a.out -> track.positions"] }), "blocked by track");
  assert.equal(
    words({ state: "sending", on: ["a.x -> z/b.in", "a.x -> c.in"] }),
    "blocked by z/b and 1 more",
  );
  assert.equal(words({ state: "old", age_s: 3 }), "not heard for 3 s");
  assert.equal(words({ state: "over", idle_s: 99 }), "finished");
});
