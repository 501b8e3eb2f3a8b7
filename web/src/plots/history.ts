// The figures of the last minutes, of the run and of each stage, and what happened in them.

import type { TrackColumns } from "../messages/message_views.ts";
import type { Run } from "../messages/run.ts";
import { largest, lossOf, slowest, stageOf } from "../words/figures.ts";

export const KEPT_MS = 5 * 60_000;
const APART_MS = 300; // at least between two samples: what a slow browser gets at once is no rate
const MARKS = 200; // kept at most

export const FIGURES = ["rate", "age", "losses", "load"] as const;
export const TARGET_FIGURES = ["height", "sigma", "residual"] as const;
export type Figure = (typeof FIGURES)[number] | (typeof TARGET_FIGURES)[number];
export type Figures = Pick<Run, "rate" | "stages" | "edges" | "paths" | "news" | "faults">;

// rate: 1/s; age: ms, 95th percentile; losses: until now, after those 1/s; load: share of a processor;
// height: of a target, m; sigma: the largest of the three that its track states, m; residual: see residualOf, px.
type Values = Partial<Record<Figure, number | null>>;

type Places = Pick<TrackColumns, "target" | "xyz" | "sigma">;

interface Sample {
  time: number; // ms
  of: Map<string, Values>; // by stage of the graph file, "" for the run, or by targetKey
}

export interface Mark {
  time: number; // ms
  text: string;
  fault: boolean;
}

export interface Point {
  time: number; // ms
  value: number | null;
}

export const targetKey = (target: number): string => `target ${target}`;

export class History {
  readonly marks: Mark[] = [];
  private samples: Sample[] = [];
  private faults = new Map<string, string>();
  private news: string[] = [];
  private places = new Map<string, Values>(); // of targets since the last sample

  // members: the instances of each stage of the graph file; residuals: of targets, px.
  take(
    time: number,
    run: Figures,
    members: Map<string, Set<string>>,
    residuals = new Map<number, number>(),
  ): void {
    this.compare(time, run);
    if (time - (this.samples.at(-1)?.time ?? -APART_MS) < APART_MS) return;
    const of = new Map([["", ofRun(run)]]);
    for (const [group, names] of members) of.set(group, ofStage(run, names));
    for (const [key, values] of this.places) of.set(key, values);
    for (const [number, residual] of residuals) {
      const key = targetKey(number);
      of.set(key, { ...of.get(key), residual });
    }
    this.places.clear();
    this.samples = [...this.samples.filter((sample) => time - sample.time <= KEPT_MS), { time, of }];
  }

  tracks({ target, xyz, sigma }: Places): void {
    target.forEach((number, i) => {
      this.places.set(targetKey(number), { height: xyz[i][2], sigma: largest(sigma[i]) });
    });
  }

  note(time: number, text: string, fault = false): void {
    this.marks.push({ time, text, fault });
    if (this.marks.length > MARKS) this.marks.shift();
  }

  points(name: string, figure: Figure): Point[] {
    const found = this.samples.map(({ time, of }) => ({ time, value: of.get(name)?.[figure] ?? null }));
    return figure === "losses" ? perSecond(found) : found;
  }

  // What is new since the last time, and what is over.
  private compare(time: number, { faults, news }: Figures): void {
    const now = new Map(faults.map((text) => [text.replace(/[\d.]+/g, ""), text]));
    for (const [key, text] of now) if (!this.faults.has(key)) this.note(time, text, true);
    for (const [key, text] of this.faults) if (!now.has(key)) this.note(time, `over: ${text}`);
    this.faults = now;
    const last = this.news.at(-1);
    const begin = last === undefined ? 0 : news.lastIndexOf(last) + 1;
    for (const text of news.slice(begin)) this.note(time, text);
    this.news = news;
  }
}

function ofRun({ rate, stages, edges, paths }: Figures): Values {
  return {
    rate,
    age: slowest(paths.filter(({ old }) => !old))?.p95_ms ?? null,
    losses: lossOf(edges),
    load: largest(stages.map(({ load }) => load)),
  };
}

function ofStage({ stages, edges }: Figures, names: Set<string>): Values {
  const instances = stages.filter(({ stage }) => names.has(stage));
  const inputs = edges.filter(({ to }) => names.has(stageOf(to)));
  return {
    rate: largest(instances.map(({ rate }) => rate)),
    age: largest(inputs.filter(({ old }) => !old).map(({ p95_ms }) => p95_ms)),
    losses: lossOf(inputs),
    load: largest(instances.map(({ load }) => load)),
  };
}

function perSecond(points: Point[]): Point[] {
  return points.slice(1).map(({ time, value }, i) => {
    const { time: before, value: of } = points[i];
    const known = value !== null && of !== null && time > before;
    return { time, value: known ? Math.max(0, (1000 * (value - of)) / (time - before)) : null };
  });
}
