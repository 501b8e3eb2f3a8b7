// Figures and states of stages and edges in words.
import type { EdgeStatus, Latency, StageStatus, State } from "../messages/run.ts";

export const LOSSES = ["away", "dropped", "late", "unmatched", "invalid", "lost"] as const;
type Losses = Pick<EdgeStatus, (typeof LOSSES)[number]>;
const WORST: State[] = [
  "absent",
  "old",
  "starting",
  "paused",
  "sending",
  "processing",
  "waiting",
  "getting",
  "over",
];
const LASTING_S = 2; // from which on the page shows how long a state has lasted

export const isFault = (state: State): boolean => state === "absent" || state === "old";

export function number(value: number | null): string {
  return value === null ? "–" : value >= 100 ? value.toFixed(0) : value.toFixed(1);
}

export function lossOf(edges: Losses[]): number {
  return edges.reduce((sum, edge) => sum + LOSSES.reduce((of, name) => of + edge[name], 0), 0);
}

// The largest of those that are known; null where none is.
export function largest(values: (number | null)[]): number | null {
  const known = values.filter((value) => value !== null);
  return known.length ? Math.max(...known) : null;
}

// The stage of a port, STAGE.PORT.
export const stageOf = (port: string): string => port.slice(0, port.lastIndexOf("."));

// A latency, ms: its median and its 95th percentile.
export function span({ p50_ms, p95_ms }: Pick<Latency, "p50_ms" | "p95_ms">): string {
  if (p50_ms === null || p95_ms === null) return "–";
  const [scale, unit, digits] = p95_ms >= 1000 ? [1000, "s", 1] : [1, "ms", p95_ms >= 100 ? 0 : 1];
  return `${(p50_ms / scale).toFixed(digits)} / ${(p95_ms / scale).toFixed(digits)} ${unit}`;
}

// Of several latencies the one with the largest 95th percentile; null where none is known.
export function slowest<L extends Latency>(latencies: L[]): L | null {
  return latencies.reduce<L | null>(
    (worst, one) => ((one.p95_ms ?? -1) > (worst?.p95_ms ?? -1) ? one : worst),
    null,
  );
}

export type Doing = Pick<StageStatus, "state" | "on" | "age_s" | "idle_s">;

export function worstOf(stages: Doing[]): State {
  return WORST.find((state) => stages.some((stage) => stage.state === state)) ?? "starting";
}

// What instances are doing, the worst first: how many are absent or old, and since when; else their state.
export function doing(stages: Doing[], source = false): string {
  const state = worstOf(stages);
  const found = stages.filter((stage) => stage.state === state);
  const idle_s = Math.min(...found.map((stage) => stage.idle_s));
  const on = found.flatMap((stage) => stage.on);
  if (!isFault(state)) return lasting({ state, on, age_s: null, idle_s }, source);
  const many = stages.length > 1 ? `${found.length} of ${stages.length} ` : "";
  return many + lasting({ state, on, age_s: largest(found.map(({ age_s }) => age_s)), idle_s }, source);
}

// A state in plain words, and since when: nobody has heard of the stage, or it has not fired.
export function lasting({ state, on, age_s, idle_s }: Doing, source = false): string {
  const since = age_s ?? idle_s;
  const long = since >= LASTING_S ? `${since.toFixed(0)} s` : "";
  if (state === "absent") return long ? `absent since ${long}` : "absent";
  if (state === "old") return long ? `not heard for ${long}` : "not heard lately";
  if (state === "over") return "finished";
  return wordsOf(state, on, source) + (long && `, ${long}`);
}

function wordsOf(state: State, on: string[], source: boolean): string {
  if (state === "getting") return source ? "waiting for its device" : "waiting for input";
  if (state === "waiting") return "waiting for its turn";
  if (state === "processing") return "working";
  if (state === "sending") return `blocked by ${blockerOf(on)}`;
  return state;
}

// The stage that takes nothing more, of edges SENDER.PORT -> READER.PORT.
function blockerOf(on: string[]): string {
  const [first, ...others] = new Set(on.map((edge) => stageOf(edge.split(" -> ")[1] ?? "")));
  if (!first) return "its readers";
  return others.length ? `${first} and ${others.length} more` : first;
}
