// The tracks of trackers beside each other as one: a target that one has lost may be tracked by another.
import type { TrackColumns } from "./message_views.ts";

const GONE_MS = 1000; // of capture time, after which a tracker that says nothing more is left out

export type Tracked = TrackColumns & { time: number };

export class MergedTracks {
  private readonly views = new Map<string, Tracked & { port: string }>(); // the newest tracks of each port

  // All targets of all trackers, each as the first tracker has it that tracks it, else as the first that has it.
  take(view: Tracked & { port: string }): Tracked {
    this.views.set(view.port, view);
    const near = [...this.views.values()].filter(({ time }) => Math.abs(view.time - time) < GONE_MS);
    near.sort((a, b) => (a.port < b.port ? -1 : 1));
    const rows = near.flatMap(rowsOf);
    const best = new Map<number, Row>();
    for (const row of [...rows.filter(({ state }) => state === "tracked"), ...rows]) {
      if (!best.has(row.target)) best.set(row.target, row);
    }
    const found = [...best.values()];
    return {
      time: Math.max(...near.map((one) => one.time)),
      target: found.map(({ target }) => target),
      state: found.map(({ state }) => state),
      xyz: found.map(({ xyz }) => xyz),
      sigma: found.map(({ sigma }) => sigma),
      quaternion: found.map(({ quaternion }) => quaternion),
    };
  }
}

type Row = ReturnType<typeof rowsOf>[number];

function rowsOf({ target, state, xyz, sigma, quaternion }: TrackColumns) {
  return target.map((number, i) => ({
    target: number,
    state: state[i],
    xyz: xyz[i],
    sigma: sigma[i],
    quaternion: quaternion[i],
  }));
}
