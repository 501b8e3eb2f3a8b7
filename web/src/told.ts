// What the server tells a browser, as tools/commands/followspot_page makes it; lengths in m, px or s as noted there.
import type { View } from "./seen.ts";
import type { Triple } from "./triple.ts";

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
  recorded: Span | null; // of a recording that is shown instead of a run
  others: boolean; // whether the page tells of other runs
  replay: boolean;
}

// Of capture time, s.
export interface Span {
  begin: number;
  end: number;
}

// Where a recording stands. at: s of capture time.
export interface Position {
  type: "position";
  at: number;
  playing: boolean;
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

// A file of marks. notes: of those who made them, or why the run marked by itself; lost: messages that are missing.
export interface Moment {
  file: string;
  notes: string[];
  state: "open" | "complete" | "failed";
  seconds: number;
  bytes: number;
  lost: number;
  problem: string;
}

// What the flight recorder holds. held: s of the port of which it holds the least; moments: the newest file, if any.
export interface Kept {
  type: "kept";
  seconds: number;
  held: number;
  bytes: number;
  lost: number;
  moments: Moment[];
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

export type Told = Scene | Run | View | Recording | Kept | Position | Answer | End;

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
export interface MarkWish {
  mark: string;
}
export interface SaveWish {
  save: true;
}
// seek: s of capture time, null for where it stands.
export interface SeekWish {
  seek: number | null;
  play: boolean;
}
export interface OpenWish {
  open: string;
}
export type Wish = Change | RecordWish | Hold | MarkWish | SaveWish | OpenWish | SeekWish;
export type Ask<W extends Wish> = (wish: W) => void;
