import assert from "node:assert/strict";
import { test } from "node:test";
import { Views } from "../src/messages/views.ts";

test("a picture is shown with the views nearest to its moment, and with none that are far from it", () => {
  const views = new Views();
  for (const time of [100, 140, 180]) views.take({ port: "color/cam0.out", time, camera: "cam0" });
  views.take({ port: "track.tracks", time: 20 });
  assert.deepEqual(
    views.at(150).map(({ port, time }) => [port, time]),
    [["color/cam0.out", 140]],
  );
});

test("a picture waits for what belongs to its camera, but not for what is a second behind", () => {
  const views = new Views();
  views.take({ port: "color/cam1.out", time: 0, camera: "cam1" });
  assert.equal(views.reached("cam0", 500), Number.POSITIVE_INFINITY);
  views.take({ port: "track.tracks", time: 400 });
  assert.equal(views.reached("cam0", 500), 420);
  assert.equal(views.reached("cam0", 1500), Number.POSITIVE_INFINITY);
});
