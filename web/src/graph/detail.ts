// An open card: its parameters, its instances and its edges. Beside the cameras, on a phone below the card.

import { make } from "../elements/make.ts";
import type { Answer } from "../messages/messages.ts";
import type { Ask, Change, SaveRequest } from "../messages/requests.ts";
import type { Run } from "../messages/run.ts";
import type { FormData, StageAbout } from "../messages/scene.ts";
import { stageOf } from "../words/figures.ts";
import { Form, Undo } from "./form.ts";
import { edgeTable, stageTable } from "./tables.ts";

export class Detail {
  forms: Record<string, FormData> = {};
  private form: { about: StageAbout; made: Form | null } | null = null;
  private readonly figures = make("div");
  private readonly element: HTMLElement;
  private readonly home: HTMLElement;
  private readonly below = make("li", "", { className: "opened" });
  private readonly back = make("button", "", { type: "button", className: "undo", hidden: true });
  private readonly undo: Undo;
  private readonly close: () => void;
  private said: Answer | null = null; // the newest answer
  private readonly save = make("button", "save as overlay", { type: "button", className: "undo" });
  private readonly saved = make("p", "", { className: "saved" });

  constructor(element: HTMLElement, send: Ask<Change | SaveRequest>, close: () => void) {
    this.element = element;
    this.home = element.parentElement ?? document.body;
    this.undo = new Undo(send);
    this.close = close;
    this.save.title =
      "writes a new graph file that extends the run's, with all that was changed while it ran";
    this.save.onclick = () => {
      this.saved.textContent = "…";
      send({ save: true });
    };
    this.saved.setAttribute("role", "status");
  }

  get id(): string {
    return this.element.id;
  }

  // about: an instance of the stage; null for none. card: below which it is shown, null for beside the cameras.
  show(about: StageAbout | null, card: HTMLElement | null): void {
    this.element.hidden = about === null;
    document.body.classList.toggle("opened", about !== null && card === null);
    this.put(card);
    if (about === null) return;
    const { group } = about;
    const form = this.forms[group];
    const made = form ? new Form(about, form, (change, before) => this.undo.ask(change, before)) : null;
    this.form = { about, made };
    this.back.onclick = () => this.undo.undo(group);
    const params = Object.entries(about.params).map(([key, value]) => `${key} ${JSON.stringify(value)}`);
    const button = make("button", "×", { type: "button", className: "close", onclick: this.close });
    button.setAttribute("aria-label", "close");
    this.element.replaceChildren(
      button,
      make("h2", `${group} · ${about.uses}`),
      this.back,
      ...(made ? [this.save, this.saved] : []),
      made?.element ?? make("p", params.join("   ") || "no parameters"),
      this.figures,
    );
    if (this.said) this.say(this.said);
  }

  tell(members: Set<string>, run: Run): void {
    const stages = run.stages.filter(({ stage }) => members.has(stage));
    const edges = run.edges.filter(({ from, to }) => members.has(stageOf(from)) || members.has(stageOf(to)));
    const errors = stages.filter(({ error }) => error).map(({ stage, error }) => `${stage}: ${error}`);
    this.figures.replaceChildren(
      ...errors.slice(0, 3).map((text) => make("pre", text)),
      stageTable(stages),
      make("h2", "edges"),
      edgeTable(edges),
    );
  }

  // What became of saving.
  tellSaved({ text, ok }: Answer): void {
    this.saved.textContent = ok ? text : `not saved: ${text}`;
  }

  answer(answer: Answer): void {
    this.undo.answer(answer.to, answer.ok);
    this.said = answer;
    this.say(answer);
  }

  private say({ to, text, ok }: Answer): void {
    if (!this.form) return;
    const { about, made } = this.form;
    const change: Change = JSON.parse(to);
    if (change.stage === about.group) made?.say(change.key, text, ok);
    const last = this.undo.last(about.group);
    this.back.hidden = last === "";
    this.back.textContent = `undo: back to ${last}`;
  }

  private put(card: HTMLElement | null): void {
    if (card === null) {
      this.below.remove();
      this.home.append(this.element);
      return;
    }
    this.below.style.setProperty("--step", card.style.getPropertyValue("--step"));
    this.below.replaceChildren(this.element);
    card.after(this.below);
  }
}
