// What the page says of where a recording stands.
import assert from "node:assert/strict";
import { test } from "node:test";
import { said } from "../src/controls/scrubber.ts";

test("a moment is told by minutes, seconds and tenths, and the length of the recording", () => {
  assert.equal(said(75.25, { begin: 1000, end: 1130 }), "1:15.2 of 2:10");
  assert.equal(said(0, { begin: 0, end: 9.9 }), "0:00.0 of 0:09");
});
