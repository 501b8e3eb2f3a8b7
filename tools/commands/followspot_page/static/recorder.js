// The record button: which ports, and how the recording is.
import { make } from "./make.js";

const size = (bytes) => (bytes < 1e6 ? `${(bytes / 1e3).toFixed(0)} kB` : bytes < 1e9 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e9).toFixed(2)} GB`);
const clock = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;

export class Recorder {
  // send: gets {on, ports}.
  constructor(element, send) {
    this.element = element;
    [this.button, this.status, this.choice] = element.children;
    this.send = send;
    this.on = false;
    this.button.onclick = () => (this.on ? this.ask({ on: false }) : this.open(this.choice.hidden));
    this.choice.onsubmit = (event) => {
      event.preventDefault();
      this.open(false);
      const boxes = [...this.choice.querySelectorAll("input")];
      const chosen = boxes.filter(({ checked }) => checked).map(({ value }) => value);
      this.ask({ on: true, ports: chosen.length === boxes.length ? "" : chosen.join(",") });
    };
    this.choice.onchange = () => (this.begin.disabled = !this.choice.querySelector("input:checked"));
  }

  // groups: stages of the graph file that can be recorded; none where this page only shows.
  show(groups) {
    this.element.hidden = groups.length === 0;
    this.begin = make("button", "start", { type: "submit" });
    const boxes = groups.map((group) => {
      const label = make("label");
      label.append(make("input", "", { type: "checkbox", value: group, checked: true }), group);
      return label;
    });
    this.choice.replaceChildren(...boxes, this.begin);
  }

  update({ state, file, bytes, messages, lost, seconds, error }) {
    this.on = state === "on";
    this.button.textContent = this.on ? "stop" : "record";
    this.element.dataset.state = state;
    const name = (file ?? "").split("/").pop();
    const figures = `${clock(seconds)} · ${size(bytes)} · ${lost ? `${lost} lost` : "nothing lost"} · ${name}`;
    this.status.textContent = state === "failed" ? `${name}: ${error}` : figures;
    this.status.title = `${file} · ${messages} messages`;
  }

  answer({ text, ok }) {
    if (!ok) {
      this.element.dataset.state = "failed";
      this.status.textContent = text;
    } else if (!this.on) this.status.title = text;
  }

  ask(wish) {
    this.status.textContent = "…";
    this.send(wish);
  }

  open(whether) {
    this.choice.hidden = !whether;
    this.button.setAttribute("aria-expanded", whether);
  }
}
