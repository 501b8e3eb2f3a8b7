// The cards of the graph: of a stage with all its instances, and of a sub-graph with all its stages.
import { FAULTS, doing, largest, lossOf, number, slowest, span, stageOf, worstOf } from "./figures.js";
import { make } from "./make.js";

export class Card {
  constructor(label, controls, onclick) {
    this.label = label;
    this.members = new Set(); // names of instances
    this.item = make("li");
    this.button = make("button", "", { type: "button", onclick });
    this.button.setAttribute("aria-expanded", "false");
    this.button.setAttribute("aria-controls", controls);
    this.name = make("b", label);
    this.state = make("span", "–", { className: "state" });
    this.note = make("span", "", { className: "note", hidden: true });
    this.load = make("i");
    const bar = make("span", "", { className: "load" });
    bar.append(this.load);
    this.button.append(this.name, this.state, this.note, bar);
    this.item.append(this.button);
  }

  // expanded: whether it is open.
  expand(expanded) {
    this.button.setAttribute("aria-expanded", expanded);
  }

  update(run) {
    const stages = run.stages.filter(({ stage }) => this.members.has(stage));
    if (!stages.length) return;
    const loss = lossOf(run.edges.filter(({ to }) => this.members.has(stageOf(to))));
    const worst = worstOf(stages);
    const failed = stages.some(({ error }) => error);
    const load = largest(stages.map((stage) => stage.load)) ?? 0;
    const many = this.many(stages);
    this.name.replaceChildren(this.label, ...(many ? [make("small", many)] : []));
    this.state.textContent = FAULTS.includes(worst) ? doing(stages) : `${number(this.rate(stages, run))}/s · ${doing(stages)}`;
    this.state.dataset.state = worst;
    this.note.hidden = !(loss || failed);
    this.note.textContent = failed ? "error" : `${loss} not delivered`;
    this.button.className = failed || worst === "absent" ? "bad" : "";
    this.button.dataset.state = worst;
    this.load.style.transform = `scaleX(${Math.min(1, load).toFixed(3)})`;
    this.button.title = `busiest instance: ${(100 * load).toFixed(0)} % of one processor`;
  }

  many(stages) {
    return stages.length > 1 ? ` ×${stages.length}` : "";
  }

  rate(stages) {
    return largest(stages.map((stage) => stage.rate));
  }
}

let made = 0;

// One card as long as it is folded; unfolded the cards within, and its own as their heading.
export class SubgraphCard extends Card {
  constructor(label, onclick) {
    const id = `within-${made++}`;
    super(label, id, onclick);
    this.groups = new Set(); // stages of the graph file
    this.item.className = "subgraph";
    this.list = make("ol", "", { id, hidden: true });
    this.latency = make("span", "", { className: "latency" });
    this.state.after(this.latency);
    this.item.append(this.list);
  }

  expand(expanded) {
    super.expand(expanded);
    this.list.hidden = !expanded;
    this.item.classList.toggle("unfolded", expanded);
  }

  update(run) {
    super.update(run);
    const slow = slowest(this.latencies(run));
    this.latency.textContent = slow === null ? "" : `latency ${span(slow.p50_ms, slow.p95_ms)}`;
    this.latency.title = "age of what leaves the sub-graph, since it entered the graph: p50 / p95";
  }

  many() {
    return ` ${this.groups.size} stage${this.groups.size > 1 ? "s" : ""}`;
  }

  // Of what leaves it; where nothing does, of the stages that nothing within takes from.
  rate(stages, { edges }) {
    const leaving = this.leaving(edges);
    if (leaving.length) return largest(leaving.map((edge) => edge.rate));
    const sending = new Set(edges.map(({ from }) => stageOf(from)));
    return largest(stages.filter(({ stage }) => !sending.has(stage)).map((stage) => stage.rate));
  }

  latencies({ edges, paths }) {
    const leaving = this.leaving(edges);
    const found = leaving.length ? leaving : paths.filter(({ sink }) => this.members.has(sink));
    return found.filter(({ old }) => !old);
  }

  leaving(edges) {
    return edges.filter(({ from, to }) => this.members.has(stageOf(from)) && !this.members.has(stageOf(to)));
  }
}
