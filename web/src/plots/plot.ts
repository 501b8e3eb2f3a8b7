// Lines of three quantities over the last seconds.
import { XYZ } from "../room/xyz.ts";

export const WINDOW_MS = 5000;
const GAP_MS = 100; // longer without a reading, a line is broken,
const GAP = 4; // if it is also so many times as long as usual
const LABEL = 12; // px of text
const QUIET = "#8ea0b8";

type Pen = CanvasRenderingContext2D;
type Place = [number, number];
type Row = (number | null)[];
export interface Point {
  time: number; // ms
  row: Row;
}

// The range of an axis around all values, at least `least` wide.
export function rangeOf(rows: Row[], least: number): [number, number] {
  const known = rows.flat().filter((value) => value !== null);
  if (!known.length) return [-least / 2, least / 2];
  const [low, high] = [Math.min(...known), Math.max(...known)];
  const wider = Math.max(0.08 * (high - low), (least - (high - low)) / 2);
  return [low - wider, high + wider];
}

// The points between gaps: pauses much longer than usual, in which nothing came.
export function unbroken<T extends { time: number }>(points: T[]): T[][] {
  const steps = points.slice(1).map(({ time }, i) => time - points[i].time);
  const usual = steps.toSorted((a, b) => a - b)[Math.floor(steps.length / 2)];
  const parts = [points.slice(0, 1)];
  steps.forEach((step, i) => {
    if (step > Math.max(GAP_MS, GAP * usual)) parts.push([]);
    parts[parts.length - 1].push(points[i + 1]);
  });
  return parts;
}

// points: the newest last, at least one; box: x, y, width, height in px; least: smallest range of the axis.
export function plot(
  pen: Pen,
  points: Point[],
  title: string,
  least: number,
  [left, top, width, height]: [number, number, number, number],
): void {
  const last = points[points.length - 1];
  const [low, high] = rangeOf(
    points.map(({ row }) => row),
    least,
  );
  const x = (time: number) => left + width * (1 - (last.time - time) / WINDOW_MS);
  const y = (value: number) => top + LABEL * 1.5 + (height - LABEL * 2) * ((high - value) / (high - low));
  pen.lineWidth = 1;
  pen.strokeStyle = "#2a3a52";
  for (const value of [low, high, ...(low < 0 && high > 0 ? [0] : [])]) {
    stroke(pen, [
      [left, y(value)],
      [left + width, y(value)],
    ]);
  }
  pen.lineWidth = 1.5;
  XYZ.forEach((color, axis) => {
    pen.strokeStyle = color;
    for (const part of unbroken(points.flatMap((point) => known(point, axis)))) {
      stroke(
        pen,
        part.map(({ time, value }) => [x(time), y(value)]),
      );
    }
  });
  pen.font = `${LABEL}px system-ui, sans-serif`;
  pen.textBaseline = "alphabetic";
  write(pen, title, QUIET, [left, top + LABEL]);
  write(pen, signed(high, 1), QUIET, [left, y(high) + LABEL]);
  write(pen, signed(low, 1), QUIET, [left, y(low) - 3]);
  last.row.forEach((value, axis) => {
    const text = `${"xyz"[axis]} ${value === null ? "–" : signed(value, 2)}`;
    write(pen, text, XYZ[axis], [left + width - (3 - axis) * LABEL * 5.2, top + LABEL]);
  });
}

function known({ time, row }: Point, axis: number): { time: number; value: number }[] {
  const value = row[axis];
  return value === null ? [] : [{ time, value }];
}

const signed = (value: number, digits: number): string => value.toFixed(digits).replace("-", "−");

function stroke(pen: Pen, places: Place[]): void {
  pen.beginPath();
  places.forEach(([x, y], i) => {
    if (i) pen.lineTo(x, y);
    else pen.moveTo(x, y);
  });
  pen.stroke();
}

function write(pen: Pen, text: string, color: string, [x, y]: Place): void {
  pen.fillStyle = color;
  pen.fillText(text, x, y);
}
