// The card of a stage with all its instances.

import { make } from "../elements/make.ts";
import type { EdgeStatus, Run, StageStatus } from "../messages/run.ts";
import { doing, isFault, largest, lossOf, number, stageOf, worstOf } from "../words/figures.ts";
import type { Standing, Step } from "./ranks.ts";

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
