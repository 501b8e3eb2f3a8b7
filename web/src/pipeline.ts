// The running graph: cards for the stages of the graph file and for its sub-graphs, details on demand.
import { Card, SubgraphCard } from "./card.ts";
import { stageOf } from "./figures.ts";
import { Form } from "./form.ts";
import { make } from "./make.ts";
import { edgeTable, stageTable } from "./tables.ts";
import type { Answer, Ask, Change, FormData, Run, StageAbout } from "./told.ts";

export class Pipeline {
  private forms: Record<string, FormData> = {};
  private about = new Map<string, StageAbout>();
  private cards = new Map<string, Card>(); // by stage of the graph file
  private subgraphs = new Map<string, SubgraphCard>();
  private readonly unfolded = new Set<string>(history.state?.unfolded ?? []); // sub-graphs, also after a reload
  private open: string | null = null;
  private form: { group: string; made: Form | null } | null = null;
  private run: Run | null = null;
  private readonly figures = make("div");
  private readonly list: HTMLElement;
  private readonly detail: HTMLElement;
  private readonly send: Ask<Change>;

  constructor(list: HTMLElement, detail: HTMLElement, send: Ask<Change>) {
    this.list = list;
    this.detail = detail;
    this.send = send;
    addEventListener("keydown", ({ key }) => key === "Escape" && this.showDetail(null));
  }

  show(stages: StageAbout[], forms: Record<string, FormData>): void {
    this.forms = forms;
    this.about = new Map(stages.map((stage) => [stage.name, stage]));
    this.cards = new Map();
    this.subgraphs = new Map();
    const items: HTMLElement[] = [];
    for (const stage of stages) {
      const holding = stage.within.map((name, depth) => this.subgraph(name, stage.within[depth - 1], items));
      for (const card of holding) {
        card.members.add(stage.name);
        card.groups.add(stage.group);
      }
      this.card(stage, holding.at(-1), items).members.add(stage.name);
    }
    this.list.replaceChildren(...items);
    for (const [name, card] of this.subgraphs) card.expand(this.unfolded.has(name));
    if (this.run) this.update(this.run);
    this.showDetail(this.isShown(this.open) ? this.open : null);
  }

  update(run: Run): void {
    this.run = run;
    for (const card of [...this.subgraphs.values(), ...this.cards.values()]) card.update(run);
    this.tell();
  }

  answer({ text, ok }: Answer): void {
    this.form?.made?.say(text, ok);
  }

  // The card of a stage of the graph file, within that of a sub-graph if there is one.
  private card(stage: StageAbout, outer: SubgraphCard | undefined, items: HTMLElement[]): Card {
    const known = this.cards.get(stage.group);
    if (known) return known;
    const toggle = () => this.showDetail(this.open === stage.group ? null : stage.group);
    const card = new Card(stage.label, this.detail.id, toggle);
    this.cards.set(stage.group, card);
    if (outer) outer.list.append(card.item);
    else items.push(card.item);
    return card;
  }

  // The card of a sub-graph, within that of `outer` if there is one; items: those outside all sub-graphs.
  private subgraph(name: string, outer: string | undefined, items: HTMLElement[]): SubgraphCard {
    const known = this.subgraphs.get(name);
    if (known) return known;
    const label = outer === undefined ? name : name.slice(outer.length + 1);
    const card = new SubgraphCard(label, () => this.fold(name));
    this.subgraphs.set(name, card);
    if (outer === undefined) items.push(card.item);
    else this.subgraphs.get(outer)?.list.append(card.item);
    return card;
  }

  // Folds a sub-graph, or unfolds it.
  private fold(name: string): void {
    if (!this.unfolded.delete(name)) this.unfolded.add(name);
    history.replaceState({ unfolded: [...this.unfolded] }, "");
    this.subgraphs.get(name)?.expand(this.unfolded.has(name));
    if (!this.isShown(this.open)) this.showDetail(null);
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

  private showDetail(group: string | null): void {
    const about = group === null ? undefined : this.aboutOf(group);
    this.open = about ? group : null;
    for (const [name, card] of this.cards) card.expand(name === this.open);
    this.detail.hidden = this.open === null;
    if (group === null || !about) return;
    const said = this.form?.group === group ? this.form.made : null;
    const form = this.forms[group];
    const made = form ? new Form(group, about, form, this.send) : null;
    this.form = { group, made };
    if (said) made?.say(said.answer.textContent, said.answer.dataset.ok !== "false");
    const params = Object.entries(about.params).map(([key, value]) => `${key} ${JSON.stringify(value)}`);
    this.detail.replaceChildren(
      make("h2", `${group} · ${about.uses}`),
      made?.element ?? make("p", params.join("   ") || "no parameters"),
      this.figures,
    );
    this.tell();
  }

  private tell(): void {
    const members = this.open === null ? undefined : this.cards.get(this.open)?.members;
    if (!this.run || !members) return;
    const stages = this.run.stages.filter(({ stage }) => members.has(stage));
    const edges = this.run.edges.filter(
      ({ from, to }) => members.has(stageOf(from)) || members.has(stageOf(to)),
    );
    const errors = stages.filter(({ error }) => error).map(({ stage, error }) => `${stage}: ${error}`);
    this.figures.replaceChildren(
      ...errors.slice(0, 3).map((text) => make("pre", text)),
      stageTable(stages),
      make("h2", "edges"),
      edgeTable(edges),
    );
  }
}
