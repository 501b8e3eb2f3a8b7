// The figures of messages that are plotted beside those of the run: chosen by port, row and field.

import type { CurveValues } from "../messages/messages.ts";
import type { Curve } from "../messages/requests.ts";
import type { FiguresData } from "../messages/scene.ts";
import type { Point } from "./history.ts";
import { KEPT_MS } from "./history.ts";

export const ROWS = "rows"; // the field that is the number of rows
export const MOST = 8; // at once, as the server allows
const APART_MS = 100; // at least between two points of a line
export const MOST_POINTS = KEPT_MS / APART_MS; // of a line

export const nameOf = ({ port, row, field }: Curve): string => `${port}${row && `[${row}]`}.${field}`;

// The unit of a figure; "" if it has none or is not offered any more.
export function unitOf({ port, field }: Curve, { ports, kinds }: FiguresData): string {
  return kinds[ports[port]]?.fields.find(({ name }) => name === field)?.unit ?? "";
}

export class Curves {
  private lines = new Map<string, { curve: Curve; points: Point[] }>();

  get chosen(): Curve[] {
    return [...this.lines.values()].map(({ curve }) => curve);
  }

  // Says whether it is plotted now and was not before.
  add(curve: Curve): boolean {
    const name = nameOf(curve);
    if (this.lines.has(name) || this.lines.size >= MOST) return false;
    this.lines.set(name, { curve, points: [] });
    return true;
  }

  remove(curve: Curve): void {
    this.lines.delete(nameOf(curve));
  }

  // now: ms by the clock of this browser.
  take(now: number, { port, values }: CurveValues): void {
    for (const [row, field, value] of values) {
      const points = this.lines.get(nameOf({ port, row, field }))?.points;
      if (!points || now - (points.at(-1)?.time ?? -APART_MS) < APART_MS) continue;
      points.push({ time: now, value });
      if (points.length > MOST_POINTS) points.shift();
    }
  }

  points(curve: Curve, now: number): Point[] {
    const points = this.lines.get(nameOf(curve))?.points ?? [];
    return points.filter(({ time }) => now - time <= KEPT_MS);
  }
}
