// What was detected and tracked lately, so that a picture is shown with what belongs to its moment.
const KEPT = 40;
const LAG_MS = 1000; // further behind, a view is not waited for
const BESIDE_MS = 20; // so much later, a picture is not kept waiting
const APART_MS = 60; // farther apart in capture time, a view and a picture do not belong together

interface Timed {
  port: string;
  time: number; // ms
  camera?: string;
}

export class Views<V extends Timed> {
  private readonly ports = new Map<string, V[]>();

  take(view: V): void {
    const past = this.ports.get(view.port) ?? [];
    past.push(view);
    if (past.length > KEPT) past.shift();
    this.ports.set(view.port, past);
  }

  // Until which moment, ms, all ports that belong to a camera have been heard of that are not far behind `now`.
  reached(camera: string, now: number): number {
    let reached = Number.POSITIVE_INFINITY;
    for (const past of this.ports.values()) {
      const { time, camera: of } = past[past.length - 1];
      if ((!of || of === camera) && time < now && now - time < LAG_MS)
        reached = Math.min(reached, time + BESIDE_MS);
    }
    return reached;
  }

  all(): V[] {
    return [...this.ports.values()].flat();
  }

  // The view of each port that is nearest to a moment, ms.
  at(time: number): V[] {
    return [...this.ports.values()].flatMap((past) => {
      const best = past.reduce((one, view) =>
        Math.abs(view.time - time) < Math.abs(one.time - time) ? view : one,
      );
      return Math.abs(best.time - time) <= APART_MS ? [best] : [];
    });
  }
}
