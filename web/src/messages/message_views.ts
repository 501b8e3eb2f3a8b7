// What was detected, tracked and read, as tools/commands/followspot_page/display/message_views.py makes it;
// m, px, rad and ms.
import type { Triple } from "./triple.ts";

interface Viewed {
  type: "view";
  port: string;
  message: string;
  time: number; // ms
  seq: number;
}

type Places = (number | null)[][];
export type Images = Record<string, (Triple | null)[]>; // by camera: x, y, radius

export interface BlobsView extends Viewed {
  kind: "Blobs";
  camera: string;
  pixel: [number, number][];
  radius: number[];
  target: number[];
}

export interface TrackColumns {
  target: number[];
  state: string[];
  xyz: Triple[];
  sigma: Places;
  quaternion: Places;
}

export interface TracksView extends Viewed, TrackColumns {
  kind: "Tracks";
  camera?: undefined;
  images: Images;
}

export interface ForecastView extends Viewed {
  kind: "Forecast";
  camera?: undefined;
  images: Images;
}

export interface PosesView extends Viewed {
  kind: "Poses";
  camera: string;
  person: number[];
  xy: [number, number][];
  height: (number | null)[];
  heading: (number | null)[];
  pan: (number | null)[];
  tilt: (number | null)[];
  sigma: Places;
  images: Images;
  arrows: Record<string, ([number, number][] | null)[]>;
}

export interface SkeletonsView extends Viewed {
  kind: "Skeletons";
  camera?: undefined;
  person: number[]; // of each bone
  bones: [Places[number], Places[number]][];
  images: Record<string, ([[number, number], [number, number]] | null)[]>;
}

export interface BoxesView extends Viewed {
  kind: "Boxes";
  camera: string;
  box: [number, number, number, number][];
}

export interface ImageTracksView extends Viewed {
  kind: "ImageTracks";
  camera: string;
  target: number[];
  pixel: [number, number][];
}

export type Drawn =
  | BlobsView
  | TracksView
  | ForecastView
  | PosesView
  | SkeletonsView
  | BoxesView
  | ImageTracksView;

export interface InertialView extends Viewed {
  kind: "Inertial";
  readings: number;
  rate: number | null;
  times: number[]; // ms
  turn_rate: (number | null)[][];
  specific_force: (number | null)[][];
}

export interface TableView extends Viewed {
  kind: "Message";
  readings: number;
  rate?: undefined;
  head: string[];
  rows: string[][];
}

export type Reading = InertialView | TableView;
export type View = Drawn | Reading;
