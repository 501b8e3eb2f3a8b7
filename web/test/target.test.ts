import assert from "node:assert/strict";
import { test } from "node:test";
import { Axes } from "../src/room/axes.ts";
import { shellOf } from "../src/room/target.ts";

function near(found: number[], expected: number[]): void {
  assert.equal(found.length, expected.length);
  found.forEach((value, i) => {
    assert.ok(Math.abs(value - expected[i]) < 1e-6, `${found} is not ${expected}`);
  });
}

test("axes turn as the quaternion says: a quarter around z turns x to y", () => {
  const axes = new Axes(0.1);
  axes.turn([Math.SQRT1_2, 0, 0, Math.SQRT1_2]);
  const along = axes.group.children[0].position.clone().applyQuaternion(axes.group.quaternion).normalize();
  near(along.toArray(), [0, 1, 0]);
  assert.ok(axes.group.visible);
});

test("no axes are drawn where no orientation is known", () => {
  const axes = new Axes(0.1);
  axes.turn([1, 0, 0, 0]);
  axes.turn([null, null, null, null]);
  assert.ok(!axes.group.visible);
  axes.turn([1, 0, 0, 0]);
  axes.turn(undefined);
  assert.ok(!axes.group.visible);
});

test("the ellipsoid is that of 95 %, and there is none where a sigma is not known", () => {
  near(shellOf(0.1, [0.01, 0.02, 0.05]) ?? [], [0.128, 0.156, 0.24]);
  assert.equal(shellOf(0.1, [0.01, null, 0.05]), null);
});
