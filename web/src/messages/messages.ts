// The messages between server and browser, as tools/commands/followspot_page makes and reads them; units as there.
import type { View } from "./message_views.ts";
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

export interface FigureField {
  name: string;
  unit: string;
}

// What can be plotted. ports: the type of the messages of each; kinds: what a type has; rows: what names a row,
// "" for a message of one row.
export interface FiguresData {
  ports: Record<string, string>;
  kinds: Record<string, { fields: FigureField[]; rows: "" | "target" | "number" }>;
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
  others: boolean; // whether the page lists other runs
  replay: boolean;
  figures: FiguresData;
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

// to: what was asked for, JSON; text: what became of it, or why nothing did; about: more of it.
export interface Answer {
  type: "answer";
  to: string;
  text: string;
  ok: boolean;
  about: StillData | LearntData | null;
}

// A still picture to learn a target from. size: px; targets: radius of each of the room file, m; file: it.
export interface StillData {
  camera: string;
  size: [number, number];
  targets: Record<string, number>;
  file: string;
}

// What was learnt, and is not written yet. new: not in the room file; hue: degrees, with the share of its pixels
// that have it; center and radius_px: where it is, px; area: what is taken for it, px; alike: other targets.
export interface LearntData {
  name: string;
  camera: string;
  new: boolean;
  color: string;
  hue: number;
  share: number;
  pixels: number;
  center: [number, number];
  radius_px: number;
  area: [number, number];
  radius_m: number;
  alike: { name: string; similarity: number; confused: boolean }[];
  minimum_saturation: number | null;
}

// A figure of a port: of the row that has this name or number, "" for a message of one row.
export interface Curve {
  port: string;
  row: string;
  field: string;
}

// The newest values of the figures of a port that browsers plot. time: ms of capture time.
export interface CurveValues {
  type: "curves";
  port: string;
  time: number;
  values: [row: string, field: string, value: number | null][];
}

export interface End {
  type: "end";
  how: string;
}

export type ServerMessage = Scene | Run | View | CurveValues | Recording | Kept | Position | Answer | End;

export interface Change {
  stage: string;
  key: string;
  value: string;
}
export interface RecordRequest {
  on: boolean;
  ports?: string;
}
export interface Hold {
  hold: "pause" | "resume" | "step";
  count: number;
}
export interface MarkRequest {
  mark: string;
}
export interface SaveRequest {
  save: true;
}
// seek: s of capture time, null for where it stands.
export interface SeekRequest {
  seek: number | null;
  play: boolean;
}
export interface OpenRequest {
  open: string;
}
export interface PlotRequest {
  plot: Curve[];
}
export interface StillRequest {
  still: string;
}
// box: a click x, y, or a rectangle x, y, width, height, px; radius: m, null for that of the room file.
export interface LearnRequest {
  learn: string;
  box: number[];
  radius: number | null;
}
export interface WriteRequest {
  write: true;
}
export type PickRequest = StillRequest | LearnRequest | WriteRequest;
export type PageRequest =
  | Change
  | RecordRequest
  | Hold
  | MarkRequest
  | SaveRequest
  | OpenRequest
  | SeekRequest
  | PlotRequest
  | PickRequest;
export type Ask<W extends PageRequest> = (request: W) => void;
