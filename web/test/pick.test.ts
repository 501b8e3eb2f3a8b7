// A target by a click or a rectangle in a still picture.
import assert from "node:assert/strict";
import { test } from "node:test";
import type { LearntData } from "../src/messages/messages.ts";
import { boxOf, learnRequestOf, learntWords } from "../src/tiles/pick.ts";

const KNOWN = { red: 0.05 };
const LEARNT: LearntData = {
  name: "red",
  camera: "cam0",
  new: false,
  color: "#f00",
  hue: 11,
  share: 0.93,
  pixels: 310,
  center: [30, 40],
  radius_px: 9.9,
  area: [77.5, 1240],
  radius_m: 0.05,
  alike: [],
  minimum_saturation: 160,
};

test("what hardly moves is a click, the rest a rectangle within the picture, in its pixels", () => {
  const [shown, size]: [number, number][] = [
    [400, 300],
    [800, 600],
  ];
  assert.deepEqual(boxOf([100, 50], [101, 52], shown, size), [200, 100]);
  assert.deepEqual(boxOf([100, 50], [120, 80], shown, size), [200, 100, 41, 61]);
  assert.deepEqual(boxOf([120, 80], [100, 50], shown, size), [200, 100, 41, 61]); // dragged to the upper left
  assert.deepEqual(boxOf([390, 290], [999, -20], shown, size), [780, 0, 20, 581]);
  assert.equal(boxOf([1, 1], [1, 1], [0, 0], size), null); // it is not shown
});

test("nothing is asked for before name, radius and place are there", () => {
  const say = (name: string, radius: string, box: number[] | null) =>
    learnRequestOf(name, radius, box, KNOWN);
  assert.equal(say("", "", [1, 2]), "name the target");
  assert.equal(say("rote Kugel", "", [1, 2]), "a name has letters, digits, _ and -");
  assert.match(say("blue", "", [1, 2]) as string, /blue is new: give its radius/);
  for (const radius of ["0", "-1", "11", "x", "NaN", "Infinity"])
    assert.match(say("blue", radius, [1, 2]) as string, /a radius is in metres/);
  assert.match(say("red", "", null) as string, /click on the middle/);
  assert.deepEqual(say("red", "", [1, 2]), { learn: "red", box: [1, 2], radius: null });
  assert.deepEqual(say("blue", "0,03", [1, 2, 3, 4]), { learn: "blue", box: [1, 2, 3, 4], radius: 0.03 });
});

test("what was learnt, how well it is told apart, and what will be written, is said", () => {
  const [colour, taken, alone, strong, written] = learntWords(LEARNT);
  assert.equal(colour, "hue 11°, 93 % of 310 px; 9.9 px in radius here");
  assert.equal(taken, "taken for it: from 78 to 1240 px");
  assert.equal(alone, "no other target is known to this camera");
  assert.match(strong, /minimum_saturation 160/);
  assert.match(written, /this colour of red in cam0, radius 0.05 m; other cameras keep theirs/);
  const beside = (confused: boolean) => [{ name: "blue", similarity: 0.31, confused }];
  assert.match(learntWords({ ...LEARNT, alike: beside(false) })[2], /most alike is blue, 31 %/);
  assert.match(learntWords({ ...LEARNT, alike: beside(true) })[2], /looks like blue/);
  assert.match(learntWords({ ...LEARNT, new: true })[4], /a new target red/);
  assert.match(learntWords({ ...LEARNT, minimum_saturation: null })[3], /pale/);
});
