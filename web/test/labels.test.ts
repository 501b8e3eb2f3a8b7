import assert from "node:assert/strict";
import { test } from "node:test";
import { lifts } from "../src/room/labels.ts";

const box = (x: number, y: number) => ({ x, y, width: 1, height: 0.5 });

test("a name that would cover one before it is lifted, by as many heights as it takes", () => {
  assert.deepEqual(lifts([box(0, 0), box(2, 0), box(0, 2)]), [0, 0, 0]);
  assert.deepEqual(lifts([box(0, 0), box(0.5, 0.1), box(0.9, 0)]), [0, 1, 2]);
  assert.deepEqual(lifts(Array.from({ length: 7 }, () => box(0, 0))), [0, 1, 2, 3, 4, 4, 4]);
});
