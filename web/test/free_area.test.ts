// Where the room is shown: beside the legend or below it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { freeOf } from "../src/room/free_area.ts";

test("the room is shown beside the legend or below it, where it is larger", () => {
  assert.deepEqual(freeOf(860, 490, 310, 110), { x: 310, y: 0, width: 550, height: 490 });
  assert.deepEqual(freeOf(600, 370, 330, 110), { x: 330, y: 0, width: 270, height: 370 });
  assert.deepEqual(freeOf(390, 440, 100, 90), { x: 0, y: 90, width: 390, height: 350 });
});

test("all of it is free where there is no legend, or where it covers everything", () => {
  assert.deepEqual(freeOf(600, 400, 0, 0), { x: 0, y: 0, width: 600, height: 400 });
  assert.deepEqual(freeOf(200, 100, 300, 200), { x: 0, y: 0, width: 200, height: 100 });
});
