// What can be changed of a stage while it works: its parameters, and which stage it is.
import { make } from "./make.js";

export class Form {
  // send: gets {stage, key, value}; key "" lets another stage take the place.
  constructor(group, about, form, send) {
    this.element = make("form", "", { onsubmit: (event) => event.preventDefault() });
    this.answer = make("p", "", { className: "answer" });
    this.answer.setAttribute("role", "status");
    const ask = (key) => (event) => {
      this.say("…", true);
      send({ stage: group, key, value: event.target.type === "checkbox" ? String(event.target.checked) : event.target.value });
    };
    if (form.alternatives.length > 1) this.element.append(field("stage", choice(form.alternatives, about.uses), ask(""), "another stage takes the place of this one"));
    for (const parameter of form.parameters) {
      const value = about.params[parameter.name];
      const title = [parameter.description, parameter.range].filter(Boolean).join(" · ");
      const unit = parameter.unit && parameter.unit !== "1" ? ` ${parameter.unit}` : "";
      this.element.append(field(parameter.name + unit, input(value, parameter.range), ask(parameter.name), title));
    }
    this.element.append(this.answer);
  }

  say(text, ok) {
    this.answer.textContent = text;
    this.answer.dataset.ok = ok;
  }
}

function field(name, control, onchange, title) {
  const label = make("label", name, { title });
  control.onchange = onchange;
  label.append(control);
  return label;
}

function choice(values, now) {
  const select = make("select");
  select.append(...values.map((value) => make("option", value, { value, selected: value === now })));
  return select;
}

function input(value, range) {
  if (range.includes(" | ")) return choice(range.split(" | "), value);
  if (typeof value === "boolean") return make("input", "", { type: "checkbox", checked: value });
  const text = typeof value === "string" ? value : JSON.stringify(value);
  return make("input", "", { type: "text", value: text, inputMode: typeof value === "number" ? "decimal" : "text", size: Math.max(6, text.length) });
}
