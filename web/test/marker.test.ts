// What the page says of a flight recorder and of the files of marks.
import assert from "node:assert/strict";
import { test } from "node:test";
import { held, said } from "../src/controls/marker.ts";
import type { Kept, Moment } from "../src/messages/messages.ts";

const MOMENT: Moment = {
  file: "/runs/demo/moment-20261123-200000.mcap",
  notes: ["blue jumped"],
  state: "complete",
  seconds: 35.04,
  bytes: 12_300_000,
  lost: 0,
  problem: "",
};
const KEPT: Kept = { type: "kept", seconds: 30, held: 29.9, bytes: 45_000_000, lost: 0, moments: [] };

test("what is held is said in seconds and bytes, and what is missing if anything is", () => {
  assert.equal(held(KEPT), "holds 30 s · 45.0 MB");
  assert.equal(held({ ...KEPT, lost: 3 }), "holds 30 s · 45.0 MB · 3 missing");
});

test("a moment is named as soon as it is saved, and says why it is not", () => {
  assert.equal(said(MOMENT), "moment-20261123-200000.mcap · 35.0 s · 12.3 MB");
  assert.equal(said({ ...MOMENT, state: "open" }), "saving moment-20261123-200000.mcap");
  const full = {
    ...MOMENT,
    state: "failed" as const,
    problem: "it is cut short: no space left\n    free some",
  };
  assert.equal(said(full), "not saved: it is cut short: no space left");
});
