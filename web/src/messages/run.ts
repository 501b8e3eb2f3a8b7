// How a run is going: what its stages do, what its edges carry, and what is wrong.
export type State =
  | "starting"
  | "getting"
  | "waiting"
  | "processing"
  | "sending"
  | "paused"
  | "old"
  | "absent"
  | "over";

// rate and load: null if nobody knows them now; age_s: since its worker was heard, null while that answers.
export interface StageStatus {
  stage: string;
  state: State;
  on: string[];
  fired: number;
  skipped: number;
  restarts: number;
  error: string;
  idle_s: number;
  worker: string;
  host: string;
  age_s: number | null;
  rate: number | null;
  load: number | null;
}

export interface Latency {
  p50_ms: number | null;
  p95_ms: number | null;
  old: boolean;
}

export interface EdgeStatus extends Latency {
  from: string;
  to: string;
  kind: string;
  rate: number | null;
  error: string;
  produced: number;
  away: number;
  sent: number;
  delivered: number;
  dropped: number;
  late: number;
  unmatched: number;
  invalid: number;
  lost: number;
  in_flight: number;
}

export interface PathStatus extends Latency {
  origin: string;
  sink: string;
}

export interface ClockStatus {
  host: string;
  warning: string;
}

export interface Run {
  type: "run";
  age_s: number;
  faults: string[];
  change_awaits: string; // what the change under way waits for
  fired: number;
  expected: number | null;
  rate: number | null;
  stages: StageStatus[];
  edges: EdgeStatus[];
  paths: PathStatus[];
  news: string[];
  clocks: ClockStatus[];
}

// A run in reach. page: its address, "" without one; shown: whether this page shows it; age_s: null if nobody knows.
export interface ListedRun {
  run: string;
  graph: string;
  hosts: string[];
  state: string;
  owner: string;
  frames: number | null;
  age_s: number | null;
  page: string;
  shown: boolean;
}
