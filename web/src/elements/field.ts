// A parameter: its value, typed or dragged, what it does, its limits and default, and what became of a change.

import type { ParameterData, Value } from "../messages/scene.ts";
import { limitsOf, rangeText, sliderOf } from "./limits.ts";
import { make } from "./make.ts";

type Control = HTMLInputElement | HTMLSelectElement;

export class Field {
  readonly element = make("div", "", { className: "field" });
  private readonly answer = make("p", "", { className: "answer" });

  // name: shown; about: lines below; ask: gets what is entered.
  constructor(name: string, unit: string, about: string, controls: Control[], ask: (value: string) => void) {
    this.answer.setAttribute("role", "status");
    const label = make("label");
    const words = make("span");
    words.append(...name.split(/(?<=_)/).flatMap((word) => [word, make("wbr")]));
    label.append(words);
    if (unit) words.append(make("small", ` ${unit}`));
    for (const control of controls) {
      const isBox = control instanceof HTMLInputElement && control.type === "checkbox";
      control.onchange = () => ask(isBox ? String(control.checked) : control.value);
      control.setAttribute("aria-label", name);
    }
    label.append(controls[0]);
    this.element.append(label, ...controls.slice(1));
    if (about) this.element.append(make("p", about, { className: "about" }));
    this.element.append(this.answer);
  }

  // A button that sets a value.
  add(button: HTMLButtonElement): void {
    this.element.insertBefore(button, this.element.children[1] ?? null);
  }

  say(text: string, ok: boolean): void {
    this.answer.textContent = text;
    this.answer.dataset.ok = String(ok);
  }
}

export const textOf = (value: Value): string => (typeof value === "string" ? value : JSON.stringify(value));

// The field of a parameter with this value.
export function parameterField(about: ParameterData, value: Value, ask: (value: string) => void): Field {
  const unit = about.unit === "1" ? "" : about.unit;
  const isChoice = about.range.includes(" | ");
  const usual = about.required ? "" : `${textOf(about.default) || "empty"} by default`;
  const limits = isChoice ? "" : rangeText(limitsOf(about.range));
  const words = [about.description, [usual, limits].filter(Boolean).join(", ")].filter(Boolean).join(" · ");
  const field = new Field(about.name, unit, words, controlsOf(about, value), ask);
  if (!about.required && JSON.stringify(about.default) !== JSON.stringify(value)) {
    const onclick = () => ask(textOf(about.default));
    field.add(make("button", "reset", { type: "button", onclick }));
  }
  return field;
}

export function choice(values: string[], now: Value): HTMLSelectElement {
  const select = make("select");
  select.append(...values.map((value) => make("option", value, { value, selected: value === now })));
  return select;
}

function controlsOf(about: ParameterData, value: Value): Control[] {
  if (about.range.includes(" | ")) return [choice(about.range.split(" | "), value)];
  if (typeof value === "boolean") return [make("input", "", { type: "checkbox", checked: value })];
  const text = textOf(value);
  const inputMode = typeof value === "number" ? "decimal" : "text";
  const size = typeof value === "number" ? 8 : Math.min(24, Math.max(8, text.length));
  const typed = make("input", "", { type: "text", value: text, inputMode, size });
  const slider = sliderOf(about, value);
  if (!slider) return [typed];
  const dragged = make("input", "", { type: "range" });
  dragged.min = `${slider.low}`;
  dragged.max = `${slider.high}`;
  dragged.step = "any";
  dragged.value = text;
  dragged.oninput = () => {
    const steps = Math.round((Number(dragged.value) - slider.low) / slider.step);
    typed.value = dragged.value = `${Number((slider.low + steps * slider.step).toPrecision(6))}`;
  };
  return [typed, dragged];
}
