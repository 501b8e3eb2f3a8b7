import assert from "node:assert/strict";
import { test } from "node:test";
import { Bones } from "../src/room/bones.ts";

const places = (bones: Bones) => [...bones.lines.geometry.getAttribute("position").array];

test("bones are lines between joints, in the colour of their person", () => {
  const bones = new Bones();
  const thigh: [number[], number[]] = [
    [0, 0, 1],
    [0, 0, 0.5],
  ];
  bones.move({ person: [1, 2], bones: [thigh, thigh] });
  assert.deepEqual(places(bones), [0, 0, 1, 0, 0, 0.5, 0, 0, 1, 0, 0, 0.5]);
  const color = bones.lines.geometry.getAttribute("color").array;
  assert.deepEqual(color.slice(0, 3), color.slice(3, 6));
  assert.notDeepEqual(color.slice(0, 3), color.slice(6, 9));
});

test("a bone whose end is not known is left out, and the others keep their colours", () => {
  const bones = new Bones();
  const arm: [number[], number[]] = [
    [1, 1, 1],
    [2, 2, 2],
  ];
  bones.move({ person: [1], bones: [arm] });
  const color = [...bones.lines.geometry.getAttribute("color").array];
  bones.move({
    person: [2, 1],
    bones: [
      [
        [null, null, null],
        [0, 0, 0],
      ],
      arm,
    ],
  });
  assert.deepEqual(places(bones), [1, 1, 1, 2, 2, 2]);
  assert.deepEqual([...bones.lines.geometry.getAttribute("color").array], color);
});
