// The cards of the graph: of a stage with all its instances, and of a sub-graph with all its stages.
import { Drawing } from "./drawing.ts";
import { doing, isFault, largest, lossOf, number, slowest, span, stageOf, worstOf } from "./figures.ts";
import { make } from "./make.ts";
import type { Standing, Step } from "./ranks.ts";
import type { EdgeStatus, Latency, Run, StageStatus } from "./told.ts";

export type Figures = Pick<Run, "stages" | "edges" | "paths">;

export class Card {
  readonly members = new Set<string>(); // names of instances
  readonly item = make("li");
  protected readonly state = make("span", "–", { className: "state" });
  private readonly often = make("span", "", { className: "rate" });
  private readonly label: string;
  protected readonly button: HTMLButtonElement;
  private readonly name: HTMLElement;
  private readonly note = make("span", "", { className: "note", hidden: true });
  private readonly load = make("i");
  private readonly source: boolean;

  constructor(label: string, controls: string, source: boolean, onclick: () => void) {
    this.label = label;
    this.source = source;
    this.button = make("button", "", { type: "button", onclick });
    this.button.setAttribute("aria-expanded", "false");
    this.button.setAttribute("aria-controls", controls);
    this.name = make("b", label);
    const bar = make("span", "", { className: "load" });
    bar.append(this.load);
    this.button.append(this.name, this.often, this.state, this.note, bar);
    this.item.append(this.button);
  }

  // Where it stands, and where in a graph that runs downwards. alone: whether no other has its rank.
  place({ rank, row }: Standing, alone: boolean, downwards: Step): void {
    const places = { rank, row, step: downwards.step, column: downwards.column };
    for (const [name, place] of Object.entries(places)) {
      this.item.style.setProperty(`--${name}`, `${place + 1}`);
    }
    this.item.classList.toggle("alone", alone);
    this.item.classList.toggle("across", downwards.alone);
  }

  // What lines begin and end at.
  get outline(): HTMLElement {
    return this.button;
  }

  // Whether it takes the whole width in a graph that runs downwards.
  get wide(): boolean {
    return false;
  }

  // expanded: whether it is open.
  expand(expanded: boolean): void {
    this.button.setAttribute("aria-expanded", String(expanded));
  }

  update(run: Figures): void {
    const stages = run.stages.filter(({ stage }) => this.members.has(stage));
    if (!stages.length) return;
    const loss = lossOf(run.edges.filter(({ to }) => this.members.has(stageOf(to))));
    const worst = worstOf(stages);
    const failed = stages.some(({ error }) => error);
    const load = largest(stages.map((stage) => stage.load)) ?? 0;
    const many = this.many(stages);
    const state = doing(stages, this.source);
    this.name.replaceChildren(this.label, ...(many ? [make("small", many)] : []));
    this.often.textContent = isFault(worst) ? "" : `${number(this.rate(stages, run.edges))}/s`;
    this.state.textContent = state;
    this.state.title = state;
    this.state.dataset.state = worst;
    this.note.hidden = !(loss || failed);
    this.note.textContent = failed ? "error" : `${loss} not delivered`;
    this.button.className = failed || worst === "absent" ? "bad" : "";
    this.button.dataset.state = worst;
    this.load.style.transform = `scaleX(${Math.min(1, load).toFixed(3)})`;
    this.button.title = `busiest instance: ${(100 * load).toFixed(0)} % of one processor`;
  }

  protected many(stages: StageStatus[]): string {
    return stages.length > 1 ? ` ×${stages.length}` : "";
  }

  protected rate(stages: StageStatus[], _edges: EdgeStatus[]): number | null {
    return largest(stages.map((stage) => stage.rate));
  }
}

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
