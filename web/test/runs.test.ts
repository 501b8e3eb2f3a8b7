// What the page says of the runs in reach.
import assert from "node:assert/strict";
import { test } from "node:test";
import { about } from "../src/controls/runs.ts";
import type { ListedRun } from "../src/messages/run.ts";

const RUN: ListedRun = {
  run: "0123456789abcdef",
  graph: "glowballs",
  hosts: ["this host", "left"],
  state: "running",
  owner: "kim",
  frames: 120,
  age_s: 75,
  page: "",
  shown: false,
};

test("a run is told in one line, without what nobody knows", () => {
  assert.equal(about(RUN), "running · this host, left · kim · 120 frames · 1:15");
  assert.equal(about({ ...RUN, owner: "", frames: null, age_s: null }), "running · this host, left");
});
