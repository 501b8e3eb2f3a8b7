import assert from "node:assert/strict";
import { test } from "node:test";
import { rangeOf, unbroken } from "../src/plots/plot.ts";

function parts(times: number[]): number[][] {
  return unbroken(times.map((time) => ({ time }))).map((part) => part.map(({ time }) => time));
}

test("a line is broken where readings are missing", () => {
  assert.deepEqual(parts([0, 10, 20, 30, 500, 510, 520, 800]), [[0, 10, 20, 30], [500, 510, 520], [800]]);
  assert.deepEqual(parts([5]), [[5]]);
  assert.deepEqual(parts([]), [[]]);
});

test("a sensor that is always slow has no gaps", () => {
  assert.deepEqual(parts([0, 300, 700, 1000]), [[0, 300, 700, 1000]]);
});

test("an axis holds all values that are known, and is never narrower than told", () => {
  const [low, high] = rangeOf(
    [
      [1, null, 5],
      [-3, 0, 2],
    ],
    0.5,
  );
  assert.ok(low < -3 && high > 5);
  assert.deepEqual(rangeOf([[2], [2]], 1), [1.5, 2.5]);
  assert.deepEqual(rangeOf([[null]], 4), [-2, 2]);
});
