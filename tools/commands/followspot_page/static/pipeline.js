// The running graph: one card for each stage of the graph file, its instances and edges on demand.
import { Form } from "./form.js";
import { make } from "./make.js";

const WORST = ["absent", "old", "starting", "paused", "sending", "processing", "waiting", "getting", "over"];
const LASTING_S = 2; // from which on it is told how long a state has lasted
const FAULTS = ["absent", "old"];
const LOSSES = ["away", "dropped", "late", "unmatched", "invalid", "lost"];

const number = (value) => (value === null ? "–" : value >= 100 ? value.toFixed(0) : value.toFixed(1));
const lossOf = (edge) => LOSSES.reduce((sum, name) => sum + edge[name], 0);

export class Pipeline {
  constructor(list, detail, send) {
    this.list = list;
    this.detail = detail;
    this.send = send;
    this.form = null;
    this.figures = make("div");
    this.cards = new Map();
    this.open = null;
    this.run = null;
    addEventListener("keydown", ({ key }) => key === "Escape" && this.show_detail(null));
  }

  show(stages, forms) {
    this.forms = forms;
    this.about = new Map(stages.map((stage) => [stage.name, stage]));
    this.cards = new Map();
    for (const { name, group } of stages) {
      const card = this.cards.get(group) ?? new Card(group, () => this.toggle(group));
      card.members.push(name);
      this.cards.set(group, card);
    }
    this.list.replaceChildren(...[...this.cards.values()].map((card) => card.item));
    if (this.run) this.update(this.run);
    this.show_detail(this.cards.has(this.open) ? this.open : null);
  }

  // The stage of the graph file of an instance.
  groupOf(stage) {
    return this.about.get(stage)?.group;
  }

  update(run) {
    this.run = run;
    for (const card of this.cards.values()) {
      const stages = run.stages.filter(({ stage }) => this.groupOf(stage) === card.group);
      const edges = run.edges.filter(({ to }) => this.groupOf(to.split(".")[0]) === card.group);
      card.update(stages, edges);
    }
    if (this.open) this.tell();
  }

  toggle(group) {
    this.show_detail(this.open === group ? null : group);
  }

  show_detail(group) {
    this.open = group;
    for (const card of this.cards.values()) card.button.setAttribute("aria-expanded", card.group === group);
    this.detail.hidden = group === null;
    if (group === null) return;
    const about = this.about.get(this.cards.get(group).members[0]);
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
    const stages = this.run.stages.filter(({ stage }) => this.groupOf(stage) === this.open);
    const ends = (end) => this.groupOf(end.slice(0, end.lastIndexOf("."))) === this.open;
    const edges = this.run.edges.filter(({ from, to }) => ends(from) || ends(to));
    const errors = stages.filter(({ error }) => error).map(({ stage, error }) => `${stage}: ${error}`);
    this.figures.replaceChildren(
      ...errors.slice(0, 3).map((text) => make("pre", text)),
      stageTable(stages),
      make("h2", "edges"),
      edgeTable(edges),
    );
  }
}

class Card {
  constructor(group, onclick) {
    this.group = group;
    this.members = [];
    this.item = make("li");
    this.button = make("button", "", { type: "button", onclick });
    this.button.setAttribute("aria-expanded", "false");
    this.button.setAttribute("aria-controls", "detail");
    this.name = make("b", group);
    this.state = make("span", "–", { className: "state" });
    this.note = make("span", "", { className: "note", hidden: true });
    this.load = make("i");
    const bar = make("span", "", { className: "load" });
    bar.append(this.load);
    this.button.append(this.name, this.state, this.note, bar);
    this.item.append(this.button);
  }

  update(stages, edges) {
    if (!stages.length) return;
    const worst = WORST.find((state) => stages.some((stage) => stage.state === state));
    const loss = edges.reduce((sum, edge) => sum + lossOf(edge), 0);
    const failed = stages.some(({ error }) => error);
    const load = Math.max(...stages.map((stage) => stage.load ?? 0));
    if (stages.length > 1) this.name.replaceChildren(this.group, make("small", ` ×${stages.length}`));
    const rate = number(Math.max(...stages.map((stage) => stage.rate)));
    const idle = Math.min(...stages.filter(({ state }) => state === worst).map(({ idle_s }) => idle_s));
    this.state.textContent = FAULTS.includes(worst) ? fault(stages, worst) : `${rate}/s · ${lasting({ state: worst, age_s: null, idle_s: idle })}`;
    this.state.dataset.state = worst;
    this.note.hidden = !(loss || failed);
    this.note.textContent = failed ? "error" : `${loss} not delivered`;
    this.button.className = failed || worst === "absent" ? "bad" : "";
    this.button.dataset.state = worst;
    this.load.style.transform = `scaleX(${Math.min(1, load).toFixed(3)})`;
    this.button.title = `busiest instance: ${(100 * load).toFixed(0)} % of one processor`;
  }
}

// How many instances of a stage are absent or old, and since when.
function fault(stages, state) {
  const found = stages.filter((stage) => stage.state === state);
  const many = stages.length > 1 ? `${found.length} of ${stages.length} ` : "";
  return many + lasting({ state, age_s: found.reduce((most, { age_s }) => (age_s ?? -1) > (most ?? -1) ? age_s : most, null) });
}

// A state, and since when: nobody has heard of the stage, or it has not fired.
function lasting({ state, age_s, idle_s }) {
  const since = age_s ?? idle_s;
  return since >= LASTING_S && state !== "over" ? `${state} ${since.toFixed(0)} s` : state;
}

// old: of each row, whether it is one of a fault.
function table(head, rows, old) {
  const element = make("table");
  const line = (tag, cells, className) => {
    const row = make("tr", "", { className });
    row.append(...cells.map((cell) => (cell instanceof Node ? cell : make(tag, cell))));
    return row;
  };
  element.append(line("th", head, ""), ...rows.map((cells, i) => line("td", cells, old[i] ? "fault" : "")));
  return element;
}

function stageTable(stages) {
  const load = (s) => (s.load === null ? "–" : `${(100 * s.load).toFixed(0)} %`);
  const rows = stages.map((s) => [s.stage, s.worker, lasting(s), waits(s), number(s.rate), load(s), s.fired, s.skipped, s.restarts]);
  return table(["stage", "worker", "state", "on", "per second", "load", "fired", "skipped", "restarts"], rows, stages.map(({ state }) => FAULTS.includes(state)));
}

function edgeTable(edges) {
  const counts = ["produced", "away", "sent", "delivered", ...LOSSES.slice(1), "in_flight"];
  const failed = edges.some(({ error }) => error);
  const rows = edges.map((edge) => [
    `${edge.from} → ${edge.to}`,
    edge.kind,
    number(edge.rate),
    number(edge.p50_ms),
    number(edge.p95_ms),
    ...counts.map((name) => make("td", edge[name], { className: LOSSES.includes(name) && edge[name] ? "lossy" : "" })),
    ...(failed ? [make("td", edge.error, { className: "lossy" })] : []),
  ]);
  const last = failed ? ["last error"] : [];
  return table(["edge", "kind", "per second", "p50 ms", "p95 ms", ...counts.map((name) => name.replace("_", " ")), ...last], rows, edges.map(({ old }) => old));
}

function waits({ state, on }) {
  const first = on[0]?.split(" -> ")[state === "sending" ? 1 : 0] ?? "";
  return on.length > 1 ? `${first} +${on.length - 1}` : first;
}
