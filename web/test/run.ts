// Stages and edges of a run for tests, as the server tells them when all is well.
import type { EdgeStatus, StageStatus } from "../src/messages/run.ts";

export function stage(name: string, but: Partial<StageStatus> = {}): StageStatus {
  const counts = { fired: 9, skipped: 0, restarts: 0 };
  const figures = { idle_s: 0, age_s: null, rate: 10, load: 0.5 };
  return {
    stage: name,
    state: "getting",
    on: [],
    ...counts,
    error: "",
    worker: "main",
    host: "",
    ...figures,
    ...but,
  };
}

export function edge(from: string, to: string, but: Partial<EdgeStatus> = {}): EdgeStatus {
  const losses = { away: 0, dropped: 0, late: 0, unmatched: 0, invalid: 0, lost: 0 };
  const counts = { produced: 9, sent: 9, delivered: 9, in_flight: 0, ...losses };
  const ages = { rate: 10, p50_ms: 1, p95_ms: 2, old: false };
  return { from: `${from}.out`, to: `${to}.in`, kind: "queue", error: "", ...counts, ...ages, ...but };
}
