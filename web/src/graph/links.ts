// The edges between cards that are seen: all edges between the instances of two cards are one link.

import type { EdgeStatus } from "../messages/run.ts";
import type { EdgePlan } from "../messages/scene.ts";
import { largest, lossOf, number, stageOf } from "../words/figures.ts";

export interface Link {
  from: string; // name of a card
  to: string;
  kind: string;
  delay: boolean; // leads to a later frame
  edges: EdgeStatus[]; // none before the first figures of the run
}

// cardOf: of each stage the card that is seen; edges within one card are left out.
export function linksOf(plan: EdgePlan[], edges: EdgeStatus[], cardOf: (stage: string) => string): Link[] {
  const figures = new Map(edges.map((edge) => [`${edge.from} ${edge.to}`, edge]));
  const links = new Map<string, Link>();
  for (const { from, to, kind, delay } of plan) {
    const [start, end] = [cardOf(stageOf(from)), cardOf(stageOf(to))];
    if (start === end) continue;
    const key = [start, end, kind, delay].join("\n");
    const link = links.get(key) ?? { from: start, to: end, kind, delay, edges: [] };
    const edge = figures.get(`${from} ${to}`);
    if (edge) link.edges.push(edge);
    links.set(key, link);
  }
  return [...links.values()];
}

// What stands at a link: its rate, the age of what it brings, and what it has lost.
export function labelOf({ edges }: Link): { rate: string; age: string; loss: string; old: boolean } {
  const old = edges.length > 0 && edges.every((edge) => edge.old);
  const rate = largest(edges.map((edge) => edge.rate));
  const age = largest(edges.filter((edge) => !edge.old).map((edge) => edge.p95_ms));
  const loss = lossOf(edges);
  return {
    rate: old ? "old" : rate === null ? "" : `${number(rate)}/s`,
    age: age === null ? "" : ageOf(age),
    loss: loss ? `−${loss}` : "",
    old,
  };
}

function ageOf(ms: number): string {
  if (ms >= 1000) return `${(ms / 1000).toFixed(1)} s`;
  return `${ms.toFixed(ms < 10 ? 1 : 0)} ms`;
}
