import assert from "node:assert/strict";
import { test } from "node:test";
import type { Images } from "../src/messages/message_views.ts";
import { residualOf, residualsOf } from "../src/plots/residual.ts";

const blobs = (camera: string, time: number, pixel: [number, number][], target: number[]) => ({
  type: "view" as const,
  port: `color/${camera}.out`,
  message: "Blobs",
  kind: "Blobs" as const,
  seq: 0,
  radius: pixel.map(() => 3),
  ...{ camera, time, pixel, target },
});

test("the residual is the median distance of the nearest blobs that may be the target's", () => {
  const images: Images = { cam0: [[10, 10, 3]], cam1: [[20, 20, 3]], cam2: [[30, 30, 3]], cam3: [null] };
  const seen = [
    blobs(
      "cam0",
      40,
      [
        [13, 14],
        [10, 10],
      ],
      [0, 1],
    ), // the nearer one is of another target
    blobs("cam1", 40, [[20, 21]], [-1]),
    blobs(
      "cam2",
      40,
      [
        [30, 90],
        [33, 30],
      ],
      [0, 0],
    ),
    blobs("cam3", 40, [[1, 1]], [0]), // does not see the target
  ];
  assert.equal(residualOf(0, 0, images, seen), 3);
  assert.equal(residualOf(0, 0, images, []), null);
  const tracks = (time: number, place: number) => ({
    ...blobs("", time, [], []),
    ...{ kind: "Tracks" as const, camera: undefined, port: "track.tracks", target: [0], state: ["tracked"] },
    ...{ xyz: [], sigma: [], quaternion: [], images: { cam0: [[place, 14, 3]] } as Images },
  });
  const early = [tracks(40.2, 13), tracks(80, 99), ...seen];
  assert.deepEqual([...residualsOf(early)], [[0, 0]]); // of the frame at 80 ms no blobs are known
  assert.deepEqual([...residualsOf([...early, tracks(2000, 99)])], []);
});
