// What the page shows a run with: the room, the sensors, the graph, and what can be changed and plotted.
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

// Of capture time, s.
export interface Span {
  begin: number;
  end: number;
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
