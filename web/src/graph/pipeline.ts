// The running graph: cards for the stages of the graph file and for its sub-graphs, with lines between them.

import type { Ask, Change, SaveRequest } from "../messages/requests.ts";
import type { Run } from "../messages/run.ts";
import type { EdgePlan, Scene, StageAbout } from "../messages/scene.ts";
import { Card } from "./card.ts";
import { Detail } from "./detail.ts";
import { Drawing } from "./drawing.ts";
import { SubgraphCard } from "./subgraph_card.ts";

export class Pipeline {
  private about = new Map<string, StageAbout>();
  private plan: EdgePlan[] = [];
  private cards = new Map<string, Card>(); // by stage of the graph file
  private subgraphs = new Map<string, SubgraphCard>();
  private readonly unfolded = new Set<string>(history.state?.unfolded ?? []); // sub-graphs, also after a reload
  private open: string | null = null;
  private run: Run | null = null;
  private readonly phone = matchMedia("(max-width: 60rem)");
  private readonly whole = new Drawing();
  readonly detail: Detail;

  // element: holds the graph; detail: where an open card is shown, beside the cameras.
  constructor(element: HTMLElement, detail: HTMLElement, send: Ask<Change | SaveRequest>) {
    element.prepend(this.whole.element);
    this.detail = new Detail(detail, send, () => this.showDetail(null));
    addEventListener("keydown", ({ key }) => key === "Escape" && this.showDetail(null));
    this.phone.onchange = () => this.showDetail(this.open);
    new ResizeObserver(() => this.draw()).observe(this.whole.element);
  }

  show({ stages, edges, forms }: Scene): void {
    this.detail.forms = forms;
    this.plan = edges;
    this.about = new Map(stages.map((stage) => [stage.name, stage]));
    this.cards = new Map();
    this.subgraphs = new Map();
    this.whole.clear();
    for (const stage of stages) {
      let drawing = this.whole;
      stage.within.forEach((name, depth) => {
        const card = this.subgraph(name, stage.within[depth - 1], drawing);
        card.members.add(stage.name);
        card.groups.add(stage.group);
        drawing = card.drawing;
      });
      this.card(stage, drawing).members.add(stage.name);
    }
    for (const [name, card] of this.subgraphs) card.expand(this.unfolded.has(name));
    this.arrange();
    if (this.run) this.update(this.run);
    this.showDetail(this.isShown(this.open) ? this.open : null);
  }

  update(run: Run): void {
    this.run = run;
    for (const card of [...this.subgraphs.values(), ...this.cards.values()]) card.update(run);
    this.tell();
    this.draw();
  }

  // The card of a stage of the graph file.
  private card(stage: StageAbout, drawing: Drawing): Card {
    const known = this.cards.get(stage.group);
    if (known) return known;
    const toggle = () => this.showDetail(this.open === stage.group ? null : stage.group);
    const card = new Card(stage.label, this.detail.id, stage.source, toggle);
    this.cards.set(stage.group, card);
    drawing.add(stage.group, card);
    return card;
  }

  // The card of a sub-graph, within that of `outer` if there is one.
  private subgraph(name: string, outer: string | undefined, drawing: Drawing): SubgraphCard {
    const known = this.subgraphs.get(name);
    if (known) return known;
    const label = outer === undefined ? name : name.slice(outer.length + 1);
    const card = new SubgraphCard(label, () => this.fold(name));
    this.subgraphs.set(name, card);
    drawing.add(name, card);
    return card;
  }

  // Folds a sub-graph, or unfolds it.
  private fold(name: string): void {
    if (!this.unfolded.delete(name)) this.unfolded.add(name);
    history.replaceState({ unfolded: [...this.unfolded] }, "");
    this.subgraphs.get(name)?.expand(this.unfolded.has(name));
    this.arrange();
    if (!this.isShown(this.open)) this.showDetail(null);
    this.draw();
  }

  // Whether there is a card of this stage, and none of the sub-graphs around it is folded.
  private isShown(group: string | null): boolean {
    const about = group === null ? undefined : this.aboutOf(group);
    return about?.within.every((name) => this.unfolded.has(name)) ?? false;
  }

  private aboutOf(group: string): StageAbout | undefined {
    const [member] = this.cards.get(group)?.members ?? [];
    return member === undefined ? undefined : this.about.get(member);
  }

  private drawings(): Drawing[] {
    return [...[...this.subgraphs.values()].reverse().map(({ drawing }) => drawing), this.whole];
  }

  private arrange(): void {
    for (const drawing of this.drawings()) drawing.arrange(this.plan);
  }

  // The innermost first: their lanes need room.
  private draw(): void {
    for (const drawing of this.drawings()) drawing.draw(this.plan, this.run?.edges ?? [], this.phone.matches);
  }

  private showDetail(group: string | null): void {
    const about = group === null ? undefined : this.aboutOf(group);
    this.open = about ? group : null;
    for (const [name, card] of this.cards) card.expand(name === this.open);
    const card = about && this.cards.get(about.group);
    this.detail.show(about ?? null, this.phone.matches ? (card?.item ?? null) : null);
    this.tell();
  }

  private tell(): void {
    const members = this.open === null ? undefined : this.cards.get(this.open)?.members;
    if (this.run && members) this.detail.tell(members, this.run);
  }
}
