// The running graph: cards for the stages of the graph file and for its sub-graphs, details on demand.
import { Card, SubgraphCard } from "./card.js";
import { stageOf } from "./figures.js";
import { Form } from "./form.js";
import { make } from "./make.js";
import { edgeTable, stageTable } from "./tables.js";

export class Pipeline {
  constructor(list, detail, send) {
    this.list = list;
    this.detail = detail;
    this.send = send;
    this.form = null;
    this.figures = make("div");
    this.cards = new Map(); // by stage of the graph file
    this.subgraphs = new Map();
    this.unfolded = new Set(history.state?.unfolded ?? []); // names of sub-graphs, also after a reload
    this.open = null;
    this.run = null;
    addEventListener("keydown", ({ key }) => key === "Escape" && this.show_detail(null));
  }

  show(stages, forms) {
    this.forms = forms;
    this.about = new Map(stages.map((stage) => [stage.name, stage]));
    this.cards = new Map();
    this.subgraphs = new Map();
    const items = [];
    for (const stage of stages) {
      const holding = stage.within.map((name, depth) => this.subgraph(name, stage.within[depth - 1], items));
      for (const card of holding) {
        card.members.add(stage.name);
        card.groups.add(stage.group);
      }
      if (!this.cards.has(stage.group)) {
        const card = new Card(stage.label, this.detail.id, () => this.toggle(stage.group));
        this.cards.set(stage.group, card);
        holding.length ? holding.at(-1).list.append(card.item) : items.push(card.item);
      }
      this.cards.get(stage.group).members.add(stage.name);
    }
    this.list.replaceChildren(...items);
    for (const [name, card] of this.subgraphs) card.expand(this.unfolded.has(name));
    if (this.run) this.update(this.run);
    this.show_detail(this.shown(this.open) ? this.open : null);
  }

  // The card of a sub-graph, within that of `outer` if there is one; items: those outside all sub-graphs.
  subgraph(name, outer, items) {
    if (!this.subgraphs.has(name)) {
      const label = outer === undefined ? name : name.slice(outer.length + 1);
      const card = new SubgraphCard(label, () => this.fold(name));
      this.subgraphs.set(name, card);
      outer === undefined ? items.push(card.item) : this.subgraphs.get(outer).list.append(card.item);
    }
    return this.subgraphs.get(name);
  }

  // Folds a sub-graph, or unfolds it.
  fold(name) {
    if (!this.unfolded.delete(name)) this.unfolded.add(name);
    history.replaceState({ unfolded: [...this.unfolded] }, "");
    this.subgraphs.get(name).expand(this.unfolded.has(name));
    if (this.open && !this.shown(this.open)) this.show_detail(null);
  }

  // Whether there is a card of this stage, and none of the sub-graphs around it is folded.
  shown(group) {
    const card = this.cards.get(group);
    if (!card) return false;
    const [member] = card.members;
    return this.about.get(member).within.every((name) => this.unfolded.has(name));
  }

  update(run) {
    this.run = run;
    for (const card of [...this.subgraphs.values(), ...this.cards.values()]) card.update(run);
    if (this.open) this.tell();
  }

  toggle(group) {
    this.show_detail(this.open === group ? null : group);
  }

  show_detail(group) {
    this.open = group;
    for (const [name, card] of this.cards) card.expand(name === group);
    this.detail.hidden = group === null;
    if (group === null) return;
    const [member] = this.cards.get(group).members;
    const about = this.about.get(member);
    const said = this.form?.group === group ? this.form.made : null;
    this.form = { group, made: this.forms[group] ? new Form(group, about, this.forms[group], this.send) : null };
    if (said && this.form.made) this.form.made.say(said.answer.textContent, said.answer.dataset.ok);
    const params = Object.entries(about.params).map(([key, value]) => `${key} ${JSON.stringify(value)}`);
    this.detail.replaceChildren(
      make("h2", `${group} · ${about.uses}`),
      this.form.made?.element ?? make("p", params.join("   ") || "no parameters"),
      this.figures,
    );
    this.tell();
  }

  answer({ text, ok }) {
    this.form?.made?.say(text, ok);
  }

  tell() {
    if (!this.run) return;
    const { members } = this.cards.get(this.open);
    const stages = this.run.stages.filter(({ stage }) => members.has(stage));
    const edges = this.run.edges.filter(({ from, to }) => members.has(stageOf(from)) || members.has(stageOf(to)));
    const errors = stages.filter(({ error }) => error).map(({ stage, error }) => `${stage}: ${error}`);
    this.figures.replaceChildren(
      ...errors.slice(0, 3).map((text) => make("pre", text)),
      stageTable(stages),
      make("h2", "edges"),
      edgeTable(edges),
    );
  }
}
