// The messages from the server, as tools/commands/followspot_page makes them; units as there.
import type { View } from "./message_views.ts";
import type { Run } from "./run.ts";
import type { Scene } from "./scene.ts";

// Where a recording stands. at: s of capture time.
export interface Position {
  type: "position";
  at: number;
  playing: boolean;
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
