// Plots of the last minutes, of the run or of one stage, with marks of what happened, and the log beside them.
import { number } from "./figures.ts";
import {
  FIGURES,
  type Figure,
  History,
  KEPT_MS,
  type Mark,
  type Point,
  TARGET_FIGURES,
  targetKey,
} from "./history.ts";
import { make } from "./make.ts";
import { residualsOf } from "./residual.ts";
import type { Drawn, TrackColumns } from "./seen.ts";
import type { Run, StageAbout, TargetData } from "./told.ts";

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 300; // of a plot, in its own units
const HEIGHT = 70;
const LINES = 60; // of the log
const TITLES: Record<Figure, [title: string, unit: string, factor: number]> = {
  rate: ["rate", "/s", 1],
  age: ["age, 95 %", "ms", 1],
  losses: ["not delivered", "/s", 1],
  load: ["busiest instance", "%", 100],
  height: ["height", "m", 1],
  sigma: ["stated error, one sigma", "mm", 1000],
  residual: ["from its blobs", "px", 1],
};

const LEAST_MS = 60_000; // shown

// How much is shown: all there is, from a minute on.
export const spanOf = (points: Point[], now: number): number =>
  Math.min(KEPT_MS, Math.max(LEAST_MS, now - (points[0]?.time ?? now)));

// The corners of a line through the points of a span, ms, broken where a value is missing; y runs down from `top`.
export function linesOf(points: Point[], now: number, span: number, top: number): string[] {
  const parts: string[][] = [[]];
  for (const { time, value } of points) {
    if (value === null) parts.push([]);
    else {
      const x = WIDTH * (1 - (now - time) / span);
      parts[parts.length - 1].push(`${x.toFixed(1)},${(HEIGHT * (1 - value / top)).toFixed(1)}`);
    }
  }
  return parts.filter((part) => part.length > 1).map((part) => part.join(" "));
}

export class Timeline {
  private readonly history = new History();
  private members = new Map<string, Set<string>>();
  private targets: TargetData[] = [];
  private readonly choice = make("select");
  private readonly plots = make("div", "", { className: "plots" });
  private readonly log = make("ol", "", { className: "log" });
  private readonly element: HTMLElement;

  constructor(element: HTMLElement, toggle: HTMLButtonElement) {
    this.element = element;
    this.choice.setAttribute("aria-label", "figures of");
    this.choice.onchange = () => this.draw();
    this.log.setAttribute("aria-label", "log");
    element.append(this.choice, this.plots, this.log);
    toggle.onclick = () => {
      element.hidden = !element.hidden;
      toggle.setAttribute("aria-expanded", String(!element.hidden));
      toggle.textContent = element.hidden ? "plots and log" : "graph";
      this.draw();
    };
  }

  show(stages: StageAbout[], targets: TargetData[]): void {
    this.targets = targets;
    const chosen = this.choice.value;
    this.members = new Map(stages.map(({ group }) => [group, new Set<string>()]));
    for (const { group, name } of stages) this.members.get(group)?.add(name);
    const names: [string, string][] = [
      ["", "the whole run"],
      ...[...this.members.keys()].map((name): [string, string] => [name, name]),
      ...targets.map(({ name }, i): [string, string] => [targetKey(i), `target ${name}`]),
    ];
    const options = names.map(([value, text]) => make("option", text, { value, selected: value === chosen }));
    this.choice.replaceChildren(...options);
  }

  // views: the last of each port.
  take(run: Run, views: Drawn[]): void {
    this.history.take(Date.now(), run, this.members, residualsOf(views));
    this.draw();
  }

  tracks(tracks: TrackColumns): void {
    this.history.tracks(tracks);
  }

  note(text: string): void {
    this.history.note(Date.now(), text);
  }

  private draw(): void {
    if (this.element.hidden) return;
    const now = Date.now();
    const { marks } = this.history;
    const target = this.targets.some((_, i) => targetKey(i) === this.choice.value);
    this.plots.replaceChildren(
      ...(target ? TARGET_FIGURES : FIGURES).map((figure) =>
        plotOf(figure, this.history.points(this.choice.value, figure), marks, now),
      ),
    );
    const lines = marks.slice(-LINES).reverse();
    this.log.replaceChildren(...lines.map(lineOf));
  }
}

function plotOf(figure: Figure, points: Point[], marks: Mark[], now: number): HTMLElement {
  const [title, unit, factor] = TITLES[figure];
  const scaled = points.map(({ time, value }) => ({ time, value: value === null ? null : factor * value }));
  const known = scaled.flatMap(({ value }) => (value === null ? [] : [value]));
  const span = spanOf(points, now);
  const top = 1.1 * Math.max(...known, 1e-3);
  const sheet = element("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none" });
  sheet.append(
    ...marks
      .filter(({ time }) => now - time < span)
      .map(({ time, fault }) => {
        const x = `${WIDTH * (1 - (now - time) / span)}`;
        return element("line", { x1: x, x2: x, y1: "0", y2: `${HEIGHT}`, class: fault ? "fault" : "" });
      }),
    ...linesOf(scaled, now, span, top).map((line) => element("polyline", { points: line })),
  );
  const most = known.length ? `most ${number(Math.max(...known))}` : "";
  const head = make("figcaption", title);
  head.append(make("b", `${number(scaled.at(-1)?.value ?? null)} ${unit}`), make("small", most));
  const made = make("figure", "", { className: "plot" });
  made.append(
    head,
    sheet,
    make("small", span > 90_000 ? `last ${Math.round(span / 60_000)} minutes` : "last minute"),
  );
  return made;
}

function lineOf({ time, text, fault }: Mark): HTMLElement {
  const line = make("li", "", { className: fault ? "fault" : "" });
  line.append(make("time", new Date(time).toLocaleTimeString([], { hour12: false })), text);
  return line;
}

function element(tag: string, attributes: Record<string, string>): SVGElement {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
