import assert from "node:assert/strict";
import { test } from "node:test";
import { MergedTracks } from "../src/messages/merged_tracks.ts";
import type { Triple } from "../src/messages/triple.ts";

type Row = [target: number, state: string, x: number];

function view(port: string, time: number, ...rows: Row[]) {
  return {
    port,
    time,
    target: rows.map(([target]) => target),
    state: rows.map(([, state]) => state),
    xyz: rows.map(([, , x]): Triple => [x, 0, 0]),
    sigma: rows.map(() => [0.1, 0.1, 0.1]),
    quaternion: [],
  };
}

test("a target is drawn as the tracker has it that tracks it", () => {
  const merged = new MergedTracks();
  const found = [
    view("stage.tracks", 1000, [0, "predicted", 1], [1, "tracked", 2]),
    view("hall.tracks", 990, [0, "tracked", 3], [2, "missing", 4]),
    view("stage.tracks", 1010, [0, "tracked", 5]),
    view("stage.tracks", 2500),
  ].map((one) => {
    const { time, target, state, xyz } = merged.take(one);
    return [time, target.map((t, i) => [t, state[i], xyz[i][0]])];
  });
  assert.deepEqual(found, [
    [
      1000,
      [
        [1, "tracked", 2],
        [0, "predicted", 1],
      ],
    ],
    [
      1000,
      [
        [0, "tracked", 3],
        [1, "tracked", 2],
        [2, "missing", 4],
      ],
    ],
    [
      1010,
      [
        [0, "tracked", 3],
        [2, "missing", 4],
      ],
    ],
    [2500, []],
  ]);
});
