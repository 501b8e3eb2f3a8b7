// What the server tells a browser, as tools/commands/followspot_page makes it; lengths in m, px or s as noted there.
import type { View } from "./seen.ts";

export type Triple = [number, number, number];
export type Value = string | number | boolean | null | Value[] | { [key: string]: Value };

export interface CameraData {
  name: string;
  kind: string;
  model: string;
  size: [number, number]; // px
  center: Triple;
  rays: Triple[]; // through the corners of the picture; none of a camera that looks all around
  depths: { farthest: number; colors: string[] } | null;
}

export interface PlaneData {
  name: string;
  corners: Triple[];
}

export interface TargetData {
  name: string;
  radius: number;
  color: string;
}

export interface RoomData {
  name: string;
  low: Triple;
  high: Triple;
  cameras: CameraData[];
  planes: PlaneData[];
  targets: TargetData[];
}

export interface SensorData {
  name: string;
  kind: string;
  rate: number | null;
  mount: string | null;
  ports: string[];
}

// An instance of a stage. group: the stage of the graph file; within: the sub-graphs that hold it, the outermost first.
export interface StageAbout {
  name: string;
  group: string;
  label: string;
  within: string[];
  uses: string;
  params: Record<string, Value>;
  camera: string | null;
  source: boolean;
}

export interface ParameterData {
  name: string;
  type: string;
  default: Value;
  required: boolean;
  range: string;
  unit: string;
  description: string;
}

export interface FormData {
  parameters: ParameterData[];
  alternatives: string[];
}

// from and to: STAGE.PORT; delay: leads to a later frame.
export interface EdgePlan {
  from: string;
  to: string;
  kind: string;
  delay: boolean;
}

export interface Scene {
  type: "scene";
  graph: string;
  room: RoomData;
  sensors: SensorData[];
  stages: StageAbout[];
  edges: EdgePlan[];
  forms: Record<string, FormData>;
  ports: string[];
  replay: boolean;
}

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
  fired: number;
  expected: number | null;
  rate: number | null;
  stages: StageStatus[];
  edges: EdgeStatus[];
  paths: PathStatus[];
  news: string[];
  clocks: ClockStatus[];
}

export interface Recording {
  type: "recording";
  state: "on" | "over" | "failed";
  file: string;
  bytes: number;
  messages: number;
  lost: number;
  seconds: number;
  error: string;
}

// to: what was asked for, JSON; text: what became of it, or why nothing did.
export interface Answer {
  type: "answer";
  to: string;
  text: string;
  ok: boolean;
}

export interface End {
  type: "end";
  how: string;
}

export type Told = Scene | Run | View | Recording | Answer | End;

export interface Change {
  stage: string;
  key: string;
  value: string;
}
export interface RecordWish {
  on: boolean;
  ports?: string;
}
export interface Hold {
  hold: "pause" | "resume" | "step";
  count: number;
}
export type Wish = Change | RecordWish | Hold;
export type Ask<W extends Wish> = (wish: W) => void;
