// Trackers beside each other: a target that one of them has lost may be tracked by another.
const GONE_MS = 1000; // of capture time, after which a tracker that says nothing more is left out

export class Together {
  constructor() {
    this.views = new Map(); // the newest tracks of each port
  }

  // All targets of all trackers, each as the first tracker has it that tracks it, else as the first that has it.
  take(view) {
    this.views.set(view.port, view);
    const near = [...this.views.values()].filter(({ time }) => Math.abs(view.time - time) < GONE_MS);
    near.sort((a, b) => (a.port < b.port ? -1 : 1));
    const rows = near.flatMap(({ target, state, xyz, sigma, quaternion }) =>
      target.map((number, i) => ({ target: number, state: state[i], xyz: xyz[i], sigma: sigma[i], quaternion: quaternion[i] })),
    );
    const best = new Map();
    for (const row of [...rows.filter(({ state }) => state === "tracked"), ...rows]) {
      if (!best.has(row.target)) best.set(row.target, row);
    }
    const column = (name) => [...best.values()].map((row) => row[name]);
    const time = Math.max(...near.map((one) => one.time));
    return { time, target: column("target"), state: column("state"), xyz: column("xyz"), sigma: column("sigma"), quaternion: column("quaternion") };
  }
}
