// A plot of one figure over the last minutes, with marks of what happened.

import { make } from "../elements/make.ts";
import { number } from "../words/figures.ts";
import { KEPT_MS, type Mark, type Point } from "./history.ts";
import { rangeOf } from "./plot.ts";

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 300; // of a plot, in its own units
const HEIGHT = 70;
const LEAST_MS = 60_000; // shown
const DIGITS = 4; // of a figure that may have any size

// fromZero: whether the axis begins at 0, else at the smallest value.
export interface Chart {
  title: string;
  unit: string;
  points: Point[];
  fromZero: boolean;
}

// How much is shown: all there is, from a minute on.
export const spanOf = (points: Point[], now: number): number =>
  Math.min(KEPT_MS, Math.max(LEAST_MS, now - (points[0]?.time ?? now)));

// A number of any size in few digits.
export const precise = (value: number | null): string =>
  value === null ? "–" : `${Number(value.toPrecision(DIGITS))}`.replace("-", "−");

// The corners of a line through the points of a span, ms, broken where a value is missing; y runs down from `top`.
export function linesOf(points: Point[], now: number, span: number, top: number, bottom = 0): string[] {
  const parts: string[][] = [[]];
  for (const { time, value } of points) {
    if (value === null) parts.push([]);
    else {
      const x = WIDTH * (1 - (now - time) / span);
      const y = (HEIGHT * (top - value)) / (top - bottom);
      parts[parts.length - 1].push(`${x.toFixed(1)},${y.toFixed(1)}`);
    }
  }
  return parts.filter((part) => part.length > 1).map((part) => part.join(" "));
}

export function chartOf({ title, unit, points, fromZero }: Chart, marks: Mark[], now: number): HTMLElement {
  const known = points.flatMap(({ value }) => (value === null ? [] : [value]));
  const span = spanOf(points, now);
  const [bottom, top] = fromZero ? [0, 1.1 * Math.max(...known, 1e-3)] : rangeOf([known], leastOf(known));
  const sheet = element("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none" });
  sheet.append(
    ...marks
      .filter(({ time }) => now - time < span)
      .map(({ time, fault }) => {
        const x = `${WIDTH * (1 - (now - time) / span)}`;
        return element("line", { x1: x, x2: x, y1: "0", y2: `${HEIGHT}`, class: fault ? "fault" : "" });
      }),
    ...linesOf(points, now, span, top, bottom).map((line) => element("polyline", { points: line })),
  );
  const head = make("figcaption", title);
  const last = points.at(-1)?.value ?? null;
  head.append(make("b", `${fromZero ? number(last) : precise(last)} ${unit}`));
  head.append(make("small", known.length ? extent(known, fromZero) : ""));
  const made = make("figure", "", { className: "plot" });
  const shown = span > 90_000 ? `last ${Math.round(span / 60_000)} minutes` : "last minute";
  made.append(head, sheet, make("small", shown));
  return made;
}

function extent(known: number[], fromZero: boolean): string {
  const most = Math.max(...known);
  return fromZero ? `most ${number(most)}` : `${precise(Math.min(...known))} to ${precise(most)}`;
}

// The smallest range of an axis: a value that hardly changes is a straight line.
const leastOf = (known: number[]): number => 1e-3 * Math.max(...known.map(Math.abs), 1e-6);

function element(tag: string, attributes: Record<string, string>): SVGElement {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
