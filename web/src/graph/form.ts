// What can be changed of a stage while it works: its parameters, and which stage it is.
import { choice, Field, parameterField, textOf } from "../elements/field.ts";
import { make } from "../elements/make.ts";
import type { Ask, Change } from "../messages/requests.ts";
import type { FormData, StageAbout } from "../messages/scene.ts";

export class Form {
  readonly element = make("form", "", { onsubmit: (event) => event.preventDefault() });
  private readonly fields = new Map<string, Field>(); // "" for which stage it is

  // send: gets the change, and what was before; its key "" lets another stage take the place.
  constructor(about: StageAbout, form: FormData, send: (change: Change, before: string) => void) {
    const ask = (key: string, before: string) => (value: string) => {
      this.say(key, "…", true);
      send({ stage: about.group, key, value }, before);
    };
    if (form.alternatives.length > 1) {
      const words = "another stage can take the place of this one";
      const select = choice(form.alternatives, about.uses);
      this.fields.set("", new Field("stage", "", words, [select], ask("", about.uses)));
    }
    for (const parameter of form.parameters) {
      const value = about.params[parameter.name] ?? null;
      this.fields.set(parameter.name, parameterField(parameter, value, ask(parameter.name, textOf(value))));
    }
    this.element.append(...[...this.fields.values()].map(({ element }) => element));
  }

  // What became of a change.
  say(key: string, text: string, ok: boolean): void {
    this.fields.get(key)?.say(text, ok);
  }
}

interface Asked {
  change: Change;
  before: string;
  undoes: boolean;
}

// Changes that were made from this page, so that they can be taken back.
export class Undo {
  private readonly asked = new Map<string, Asked>(); // by its JSON
  private readonly made: Asked[] = [];
  private readonly send: Ask<Change>;

  constructor(send: Ask<Change>) {
    this.send = send;
  }

  ask(change: Change, before: string, undoes = false): void {
    this.asked.set(JSON.stringify(change), { change, before, undoes });
    this.send(change);
  }

  // to: the change that was answered, JSON.
  answer(to: string, ok: boolean): void {
    const asked = this.asked.get(to);
    this.asked.delete(to);
    if (ok && asked && !asked.undoes && asked.before !== asked.change.value) this.made.push(asked);
  }

  // The newest change of a stage, in words; "" where there is none.
  last(stage: string): string {
    const found = this.made.findLast(({ change }) => change.stage === stage);
    return found ? `${found.change.key || "stage"} = ${found.before}` : "";
  }

  // Takes the newest change of a stage back.
  undo(stage: string): void {
    const at = this.made.findLastIndex(({ change }) => change.stage === stage);
    if (at < 0) return;
    const [{ change, before }] = this.made.splice(at, 1);
    this.ask({ ...change, value: before }, change.value, true);
  }
}
