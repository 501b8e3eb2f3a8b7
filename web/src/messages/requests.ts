// What a browser asks of the server.

// A figure of a port: of the row that has this name or number, "" for a message of one row.
export interface Curve {
  port: string;
  row: string;
  field: string;
}

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
