// What can be changed of a stage while it works: its parameters, and which stage it is.
import { make } from "./make.ts";
import type { Ask, Change, FormData, StageAbout, Value } from "./told.ts";

type Control = HTMLInputElement | HTMLSelectElement;

export class Form {
  readonly element = make("form", "", { onsubmit: (event) => event.preventDefault() });
  readonly answer = make("p", "", { className: "answer" });

  // send: gets the change; its key "" lets another stage take the place.
  constructor(group: string, about: StageAbout, form: FormData, send: Ask<Change>) {
    this.answer.setAttribute("role", "status");
    const ask = (key: string) => (value: string) => {
      this.say("…", true);
      send({ stage: group, key, value });
    };
    if (form.alternatives.length > 1) {
      const title = "another stage takes the place of this one";
      this.element.append(field("stage", choice(form.alternatives, about.uses), ask(""), title));
    }
    for (const parameter of form.parameters) {
      const value = about.params[parameter.name];
      const title = [parameter.description, parameter.range].filter(Boolean).join(" · ");
      const unit = parameter.unit && parameter.unit !== "1" ? ` ${parameter.unit}` : "";
      const control = input(value, parameter.range);
      this.element.append(field(parameter.name + unit, control, ask(parameter.name), title));
    }
    this.element.append(this.answer);
  }

  say(text: string, ok: boolean): void {
    this.answer.textContent = text;
    this.answer.dataset.ok = String(ok);
  }
}

function field(
  name: string,
  control: Control,
  ask: (value: string) => void,
  title: string,
): HTMLLabelElement {
  const label = make("label", name, { title });
  const isBox = control instanceof HTMLInputElement && control.type === "checkbox";
  control.onchange = () => ask(isBox ? String(control.checked) : control.value);
  label.append(control);
  return label;
}

function choice(values: string[], now: Value): HTMLSelectElement {
  const select = make("select");
  select.append(...values.map((value) => make("option", value, { value, selected: value === now })));
  return select;
}

function input(value: Value, range: string): Control {
  if (range.includes(" | ")) return choice(range.split(" | "), value);
  if (typeof value === "boolean") return make("input", "", { type: "checkbox", checked: value });
  const text = typeof value === "string" ? value : JSON.stringify(value);
  const inputMode = typeof value === "number" ? "decimal" : "text";
  return make("input", "", { type: "text", value: text, inputMode, size: Math.max(6, text.length) });
}
