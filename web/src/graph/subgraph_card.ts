// The card of a sub-graph with all its stages.

import { make } from "../elements/make.ts";
import type { EdgeStatus, Latency, Run, StageStatus } from "../messages/run.ts";
import { largest, slowest, span, stageOf } from "../words/figures.ts";
import { Card, type Figures } from "./card.ts";
import { Drawing } from "./drawing.ts";

let made = 0;

// One card as long as it is folded; unfolded the cards within, and its own as their heading.
export class SubgraphCard extends Card {
  readonly groups = new Set<string>(); // stages of the graph file
  readonly drawing = new Drawing();
  private readonly latency = make("span", "", { className: "latency" });

  constructor(label: string, onclick: () => void) {
    const id = `within-${made++}`;
    super(label, id, false, onclick);
    this.item.className = "subgraph";
    this.drawing.element.id = id;
    this.drawing.element.hidden = true;
    this.state.after(this.latency);
    this.item.append(this.drawing.element);
  }

  override expand(expanded: boolean): void {
    super.expand(expanded);
    this.drawing.element.hidden = !expanded;
    this.item.classList.toggle("unfolded", expanded);
  }

  override get outline(): HTMLElement {
    return this.wide ? this.item : this.button;
  }

  override get wide(): boolean {
    return this.item.classList.contains("unfolded");
  }

  override update(run: Figures): void {
    super.update(run);
    const slow = slowest(latenciesOf(this.members, run));
    this.latency.textContent = slow === null ? "" : `latency ${span(slow)}`;
    this.latency.title = "age of what leaves the sub-graph, since it entered the graph: p50 / p95";
  }

  protected override many(): string {
    return ` ${this.groups.size} stage${this.groups.size > 1 ? "s" : ""}`;
  }

  protected override rate(stages: StageStatus[], edges: EdgeStatus[]): number | null {
    return rateOf(this.members, stages, edges);
  }
}

// The rate of what leaves a sub-graph; where nothing does, of the stages that nothing within takes from.
export function rateOf(
  members: Set<string>,
  stages: Pick<StageStatus, "stage" | "rate">[],
  edges: Pick<EdgeStatus, "from" | "to" | "rate">[],
): number | null {
  const outgoing = leaving(members, edges);
  if (outgoing.length) return largest(outgoing.map((edge) => edge.rate));
  const sending = new Set(edges.map(({ from }) => stageOf(from)));
  return largest(stages.filter(({ stage }) => !sending.has(stage)).map((stage) => stage.rate));
}

// Ages of what leaves a sub-graph; where nothing does, of what its last stages take.
export function latenciesOf(members: Set<string>, { edges, paths }: Pick<Run, "edges" | "paths">): Latency[] {
  const outgoing: Latency[] = leaving(members, edges);
  const found = outgoing.length ? outgoing : paths.filter(({ sink }) => members.has(sink));
  return found.filter(({ old }) => !old);
}

function leaving<E extends Pick<EdgeStatus, "from" | "to">>(members: Set<string>, edges: E[]): E[] {
  return edges.filter(({ from, to }) => members.has(stageOf(from)) && !members.has(stageOf(to)));
}
