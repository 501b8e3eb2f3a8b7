// What was detected and tracked lately, so that a picture is shown with what belongs to its moment.
const KEPT = 40;
const LAG_MS = 1000; // further behind, a view is not waited for
const BESIDE_MS = 20; // so much later, a picture is not kept waiting
const APART_MS = 60; // farther apart in capture time, a view and a picture do not belong together

export class Views {
  constructor() {
    this.ports = new Map();
  }

  take(view) {
    const past = this.ports.get(view.port) ?? [];
    past.push(view);
    if (past.length > KEPT) past.shift();
    this.ports.set(view.port, past);
  }

  // Until which moment, ms, all ports that belong to a camera have been heard of that are not far behind `now`.
  reached(camera, now) {
    let reached = Infinity;
    for (const past of this.ports.values()) {
      const { time, camera: of } = past.at(-1);
      if ((!of || of === camera) && time < now && now - time < LAG_MS) reached = Math.min(reached, time + BESIDE_MS);
    }
    return reached;
  }

  // The view of each port that is nearest to a moment, ms.
  at(time) {
    const found = [];
    for (const past of this.ports.values()) {
      let best = null;
      for (const view of past) {
        if (best === null || Math.abs(view.time - time) < Math.abs(best.time - time)) best = view;
      }
      if (best && Math.abs(best.time - time) <= APART_MS) found.push(best);
    }
    return found;
  }
}
