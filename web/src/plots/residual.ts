// How far the blobs of a moment are from where a target is seen by its track.
import type { BlobsView, Drawn, Images } from "../messages/message_views.ts";

const SAME_MS = 1; // farther apart in capture time, blobs and tracks are of different frames
const LATE_MS = 1000; // older than the newest tracks, they tell nothing of now

// The residual of each target, px, in the newest frame of which both its track and blobs are known.
export function residualsOf(views: Drawn[]): Map<number, number> {
  const tracks = views.filter((view) => view.kind === "Tracks").sort((a, b) => b.time - a.time);
  const found = new Map<number, number>();
  for (const { time, target, images } of tracks.filter((one) => tracks[0].time - one.time < LATE_MS)) {
    const blobs = views.filter((view) => view.kind === "Blobs" && Math.abs(view.time - time) < SAME_MS);
    target.forEach((number, row) => {
      const residual = residualOf(number, row, images, blobs as BlobsView[]);
      if (residual !== null && !found.has(number)) found.set(number, residual);
    });
  }
  return found;
}

// Median over the cameras, px, of the distance to the nearest blob that may be the target's; null if none has one.
// row: of the target among the tracks, whose images these are.
export function residualOf(target: number, row: number, images: Images, blobs: BlobsView[]): number | null {
  const distances = blobs.flatMap(({ camera, pixel, target: of }) => {
    const seen = images[camera]?.[row];
    if (!seen) return [];
    const own = pixel.filter((_, k) => of[k] === target || of[k] < 0);
    const all = own.map(([x, y]) => Math.hypot(x - seen[0], y - seen[1]));
    return all.length ? [Math.min(...all)] : [];
  });
  return distances.sort((a, b) => a - b)[distances.length >> 1] ?? null;
}
