// Figures and states of stages and edges in words.
export const LOSSES = ["away", "dropped", "late", "unmatched", "invalid", "lost"];
export const FAULTS = ["absent", "old"];
const WORST = ["absent", "old", "starting", "paused", "sending", "processing", "waiting", "getting", "over"];
const LASTING_S = 2; // from which on it is told how long a state has lasted

export const number = (value) => (value === null ? "–" : value >= 100 ? value.toFixed(0) : value.toFixed(1));
export const lossOf = (edges) => edges.reduce((sum, edge) => sum + LOSSES.reduce((of, name) => of + edge[name], 0), 0);
export const largest = (values) => values.reduce((most, value) => (value !== null && value > (most ?? -1) ? value : most), null);

// The stage of a port, STAGE.PORT.
export const stageOf = (port) => port.slice(0, port.lastIndexOf("."));

// A latency, ms: its median and its 95th percentile.
export function span(p50, p95) {
  const [scale, unit, digits] = p95 >= 1000 ? [1000, "s", 1] : [1, "ms", p95 >= 100 ? 0 : 1];
  return `${(p50 / scale).toFixed(digits)} / ${(p95 / scale).toFixed(digits)} ${unit}`;
}

// Of several latencies the one with the largest 95th percentile; null where none is known.
export const slowest = (latencies) => latencies.reduce((worst, one) => ((one.p95_ms ?? -1) > (worst?.p95_ms ?? -1) ? one : worst), null);

export const worstOf = (stages) => WORST.find((state) => stages.some((stage) => stage.state === state));

// What instances are doing, the worst first: how many are absent or old, and since when; else their state.
export function doing(stages) {
  const state = worstOf(stages);
  const found = stages.filter((stage) => stage.state === state);
  if (!FAULTS.includes(state)) return lasting({ state, age_s: null, idle_s: Math.min(...found.map(({ idle_s }) => idle_s)) });
  const many = stages.length > 1 ? `${found.length} of ${stages.length} ` : "";
  return many + lasting({ state, age_s: largest(found.map(({ age_s }) => age_s)) });
}

// A state, and since when: nobody has heard of the stage, or it has not fired.
export function lasting({ state, age_s, idle_s }) {
  const since = age_s ?? idle_s;
  return since >= LASTING_S && state !== "over" ? `${state} ${since.toFixed(0)} s` : state;
}
