// The record button: which ports, and how the recording is.

import { make } from "../elements/make.ts";
import type { Answer, Recording } from "../messages/messages.ts";
import type { Ask, RecordRequest } from "../messages/requests.ts";
import { clock, size } from "../words/amounts.ts";

export interface RecorderParts {
  element: HTMLElement;
  record: HTMLButtonElement;
  recorded: HTMLElement;
  choice: HTMLFormElement;
}

export class Recorder {
  private on = false;
  private begin = make("button");
  private readonly parts: RecorderParts;
  private readonly send: Ask<RecordRequest>;

  constructor(parts: RecorderParts, send: Ask<RecordRequest>) {
    this.parts = parts;
    this.send = send;
    const { record, choice } = parts;
    record.onclick = () => (this.on ? this.ask({ on: false }) : this.open(choice.hidden === true));
    choice.onsubmit = (event) => {
      event.preventDefault();
      this.open(false);
      this.ask({ on: true, ports: this.chosen() });
    };
    choice.onchange = () => {
      this.begin.disabled = !choice.querySelector("input:checked");
    };
  }

  // groups: stages of the graph file that can be recorded; none where this page only shows.
  show(groups: string[]): void {
    this.parts.element.hidden = groups.length === 0;
    this.begin = make("button", "start", { type: "submit" });
    const boxes = groups.map((group) => {
      const label = make("label");
      label.append(make("input", "", { type: "checkbox", value: group, checked: true }), group);
      return label;
    });
    this.parts.choice.replaceChildren(...boxes, this.begin);
  }

  update({ state, file, bytes, messages, lost, seconds, error }: Recording): void {
    this.on = state === "on";
    const { element, record, recorded } = this.parts;
    record.textContent = this.on ? "stop" : "record";
    element.dataset.state = state;
    const name = (file ?? "").split("/").pop();
    const losses = lost ? `${lost} lost` : "nothing lost";
    const figures = `${clock(seconds)} · ${size(bytes)} · ${losses} · ${name}`;
    recorded.textContent = state === "failed" ? `${name}: ${error}` : figures;
    recorded.title = `${file} · ${messages} messages`;
  }

  answer({ text, ok }: Answer): void {
    const { element, recorded } = this.parts;
    if (!ok) {
      element.dataset.state = "failed";
      recorded.textContent = text;
    } else if (!this.on) recorded.title = text;
  }

  // The chosen stages as the server takes them; "" for all.
  private chosen(): string {
    const boxes = [...this.parts.choice.querySelectorAll("input")];
    const chosen = boxes.filter(({ checked }) => checked).map(({ value }) => value);
    return chosen.length === boxes.length ? "" : chosen.join(",");
  }

  private ask(request: RecordRequest): void {
    this.parts.recorded.textContent = "…";
    this.send(request);
  }

  private open(whether: boolean): void {
    this.parts.choice.hidden = !whether;
    this.parts.record.setAttribute("aria-expanded", String(whether));
  }
}
