// Chooses a figure to plot: a port of a stage, a field of its messages, and a row.

import { choice } from "../elements/field.ts";
import { make } from "../elements/make.ts";
import type { Curve } from "../messages/requests.ts";
import type { FiguresData } from "../messages/scene.ts";
import { stageOf } from "../words/figures.ts";
import { MOST, ROWS } from "./curves.ts";

export class CurveForm {
  readonly element = make("form", "", { className: "curves" });
  private readonly port = make("select");
  private readonly field = make("select");
  private readonly target = make("select");
  private readonly row = make("input", "0", { type: "text", inputMode: "numeric", value: "0", size: 3 });
  private readonly said = make("span");
  private figures: FiguresData = { ports: {}, kinds: {} };
  private shown = "";

  constructor(add: (curve: Curve) => void) {
    this.port.setAttribute("aria-label", "port");
    this.field.setAttribute("aria-label", "field");
    this.target.setAttribute("aria-label", "target");
    this.row.setAttribute("aria-label", "row");
    this.said.setAttribute("role", "status");
    this.port.onchange = () => this.renew();
    this.field.onchange = () => this.showRows();
    this.element.onsubmit = (event) => {
      event.preventDefault();
      this.say("");
      if (this.field.value) add(this.chosen());
    };
    const button = make("button", "plot", { type: "submit" });
    button.title = `at most ${MOST} at once`;
    this.element.append(this.port, this.field, this.target, this.row, button, this.said);
  }

  show(figures: FiguresData, targets: string[]): void {
    const options = JSON.stringify([figures, targets]);
    if (options === this.shown) return; // a list that is open stays so
    this.shown = options;
    this.figures = figures;
    this.element.hidden = !Object.keys(figures.ports).length;
    const before = this.port.value;
    const lists = new Map<string, HTMLElement>();
    for (const value of Object.keys(figures.ports)) {
      const label = stageOf(value).split("/")[0];
      const list = lists.get(label) ?? make("optgroup", "", { label });
      list.append(make("option", value, { value, selected: value === before }));
      lists.set(label, list);
    }
    this.port.replaceChildren(...lists.values());
    this.target.replaceChildren(...choice(targets, targets[0] ?? "").children);
    this.renew();
  }

  say(text: string): void {
    this.said.textContent = text;
  }

  private renew(): void {
    const kind = this.figures.kinds[this.figures.ports[this.port.value]];
    const before = this.field.value;
    const fields = kind?.fields ?? [];
    const options = fields.map(({ name, unit }) =>
      make("option", unit ? `${name}, ${unit}` : name, { value: name, selected: name === before }),
    );
    this.field.replaceChildren(...options);
    this.showRows();
  }

  // What names the row of the chosen field; "" where it needs no row.
  private get rows(): string {
    if (this.field.value === ROWS) return "";
    return this.figures.kinds[this.figures.ports[this.port.value]]?.rows ?? "";
  }

  private showRows(): void {
    this.target.hidden = this.rows !== "target";
    this.row.hidden = this.rows !== "number";
  }

  private chosen(): Curve {
    const { rows } = this;
    const row = rows === "target" ? this.target.value : rows === "number" ? this.row.value.trim() : "";
    return { port: this.port.value, row, field: this.field.value };
  }
}
