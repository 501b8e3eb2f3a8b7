// What is drawn over a camera's picture: what was detected, where it was searched, where tracks are.
import type {
  BlobsView,
  BoxesView,
  Drawn,
  ForecastView,
  ImageTracksView,
  PosesView,
  SkeletonsView,
  TracksView,
} from "../messages/message_views.ts";

type Place = [number, number];
const PERSON_HUES = [205, 28, 140, 275, 52, 330];

// camera: whose picture it is; line: width in px of the picture of a line of width 1; colors: of targets.
export interface Sheet {
  pen: CanvasRenderingContext2D;
  camera: string;
  line: (number: number) => number;
  colors: string[];
}

export function overlay(sheet: Sheet, view: Drawn): void {
  if (view.kind === "Blobs") blobs(sheet, view);
  else if (view.kind === "Forecast") forecast(sheet, view);
  else if (view.kind === "Tracks") tracks(sheet, view);
  else if (view.kind === "Boxes") boxes(sheet, view);
  else if (view.kind === "Poses") poses(sheet, view);
  else if (view.kind === "Skeletons") skeletons(sheet, view);
  else imageTracks(sheet, view);
}

function blobs(sheet: Sheet, { pixel, radius, target }: BlobsView): void {
  pixel.forEach(([x, y], i) => {
    circle(sheet, [x, y, radius[i] + sheet.line(2)], sheet.colors[target[i]] ?? "#ffffff99");
  });
}

function forecast(sheet: Sheet, { images }: ForecastView): void {
  images[sheet.camera]?.forEach((place, t) => {
    if (!place) return;
    const radius = Math.min(Math.max(place[2], sheet.line(9)), sheet.line(60));
    circle(sheet, [place[0], place[1], radius], `${sheet.colors[t]}66`, { width: 0.9, dash: [3, 3] });
  });
}

function tracks(sheet: Sheet, { target, images }: TracksView): void {
  const { pen, line } = sheet;
  images[sheet.camera]?.forEach((place, i) => {
    if (!place) return;
    const [x, y, r] = place;
    const inner = Math.max(r, line(3)) + line(3);
    const outer = inner + line(4);
    begin(sheet, sheet.colors[target[i]] ?? "#fff", 1.6);
    for (const [dx, dy] of [
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
    ]) {
      pen.moveTo(x + dx * inner, y + dy * inner);
      pen.lineTo(x + dx * outer, y + dy * outer);
    }
    pen.stroke();
  });
}

function boxes(sheet: Sheet, { box }: BoxesView): void {
  begin(sheet, "#ffffff99", 1);
  for (const [x0, y0, x1, y1] of box) sheet.pen.strokeRect(x0, y0, x1 - x0, y1 - y0);
}

const personColor = (number: number) => `hsl(${PERSON_HUES[number % PERSON_HUES.length]} 90% 65%)`;

function poses(sheet: Sheet, { person, images, arrows }: PosesView): void {
  const color = (i: number) => personColor(person[i]);
  images[sheet.camera]?.forEach((place, i) => {
    if (place) circle(sheet, place, color(i), { width: 1.6 });
  });
  arrows[sheet.camera]?.forEach((points, i) => {
    if (!points) return;
    const [head, gaze, chest, front] = points;
    arrow(sheet, head, gaze, color(i), 1.6);
    arrow(sheet, chest, front, color(i), 2.6);
  });
}

function skeletons(sheet: Sheet, { person, images }: SkeletonsView): void {
  images[sheet.camera]?.forEach((ends, i) => {
    if (!ends) return;
    begin(sheet, personColor(person[i]), 1.6);
    sheet.pen.moveTo(...ends[0]);
    sheet.pen.lineTo(...ends[1]);
    sheet.pen.stroke();
  });
}

function imageTracks(sheet: Sheet, { target, pixel }: ImageTracksView): void {
  pixel.forEach(([x, y], i) => {
    circle(sheet, [x, y, sheet.line(8)], sheet.colors[target[i]] ?? "#fff", { width: 1.6 });
  });
}

function begin({ pen, line }: Sheet, color: string, width: number, dash: number[] = []): void {
  pen.strokeStyle = color;
  pen.lineWidth = line(width);
  pen.setLineDash(dash.map(line));
  pen.beginPath();
}

function circle(
  sheet: Sheet,
  [x, y, r]: [number, number, number],
  color: string,
  { width = 1.2, dash = [] }: { width?: number; dash?: number[] } = {},
): void {
  begin(sheet, color, width, dash);
  sheet.pen.arc(x, y, Math.max(r, sheet.line(2)), 0, 2 * Math.PI);
  sheet.pen.stroke();
}

function arrow(sheet: Sheet, [x0, y0]: Place, [x1, y1]: Place, color: string, width: number): void {
  const { pen } = sheet;
  const along = Math.atan2(y1 - y0, x1 - x0);
  const barb = Math.min(sheet.line(6), Math.hypot(x1 - x0, y1 - y0) / 2);
  begin(sheet, color, width);
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  for (const side of [-0.5, 0.5]) {
    pen.moveTo(x1, y1);
    pen.lineTo(x1 - barb * Math.cos(along + side), y1 - barb * Math.sin(along + side));
  }
  pen.stroke();
}
