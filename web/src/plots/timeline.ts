// Plots of the last minutes, of the run, of one stage and of figures of messages, and the log beside them.

import { make } from "../elements/make.ts";
import type { Drawn, TrackColumns } from "../messages/message_views.ts";
import type { Answer, CurveValues } from "../messages/messages.ts";
import type { Ask, Curve, PlotRequest } from "../messages/requests.ts";
import type { Run } from "../messages/run.ts";
import type { FiguresData, StageAbout, TargetData } from "../messages/scene.ts";
import { type Chart, chartOf } from "./chart.ts";
import { CurveForm } from "./curve_form.ts";
import { Curves, MOST, nameOf, unitOf } from "./curves.ts";
import { FIGURES, type Figure, History, type Mark, TARGET_FIGURES, targetKey } from "./history.ts";
import { residualsOf } from "./residual.ts";

const LINES = 60; // of the log
const TITLES: Record<Figure, [title: string, unit: string, factor: number]> = {
  rate: ["rate", "/s", 1],
  age: ["age, 95 %", "ms", 1],
  losses: ["not delivered", "/s", 1],
  load: ["busiest instance", "%", 100],
  height: ["height", "m", 1],
  sigma: ["stated error, one sigma", "mm", 1000],
  residual: ["from its blobs", "px", 1],
};

export class Timeline {
  private readonly history = new History();
  private members = new Map<string, Set<string>>();
  private targets: TargetData[] = [];
  private readonly curves = new Curves();
  private figures: FiguresData = { ports: {}, kinds: {} };
  private readonly choice = make("select");
  private readonly form = new CurveForm((curve) => this.add(curve));
  private readonly plots = make("div", "", { className: "plots" });
  private readonly log = make("ol", "", { className: "log" });
  private readonly element: HTMLElement;
  private readonly send: Ask<PlotRequest>;

  constructor(element: HTMLElement, toggle: HTMLButtonElement, send: Ask<PlotRequest>) {
    this.element = element;
    this.send = send;
    this.choice.setAttribute("aria-label", "figures of");
    this.choice.onchange = () => this.draw();
    this.log.setAttribute("aria-label", "log");
    const choices = make("div", "", { className: "choices" });
    choices.append(this.choice, this.form.element);
    element.append(choices, this.plots, this.log);
    toggle.onclick = () => {
      element.hidden = !element.hidden;
      toggle.setAttribute("aria-expanded", String(!element.hidden));
      toggle.textContent = element.hidden ? "plots and log" : "graph";
      this.draw();
    };
  }

  show(stages: StageAbout[], targets: TargetData[], figures: FiguresData): void {
    this.targets = targets;
    this.figures = figures;
    this.form.show(
      figures,
      targets.map(({ name }) => name),
    );
    const chosen = this.choice.value;
    this.members = new Map(stages.map(({ group }) => [group, new Set<string>()]));
    for (const { group, name } of stages) this.members.get(group)?.add(name);
    const names: [string, string][] = [
      ["", "the whole run"],
      ...[...this.members.keys()].map((name): [string, string] => [name, name]),
      ...targets.map(({ name }, i): [string, string] => [targetKey(i), `target ${name}`]),
    ];
    const options = names.map(([value, text]) => make("option", text, { value, selected: value === chosen }));
    this.choice.replaceChildren(...options);
  }

  // views: the last of each port.
  take(run: Run, views: Drawn[]): void {
    this.history.take(Date.now(), run, this.members, residualsOf(views));
    this.draw();
  }

  tracks(tracks: TrackColumns): void {
    this.history.tracks(tracks);
  }

  note(text: string): void {
    this.history.note(Date.now(), text);
  }

  takeCurves(curves: CurveValues): void {
    this.curves.take(Date.now(), curves);
  }

  // What became of the request to plot.
  answer({ text, ok }: Answer): void {
    this.form.say(ok ? "" : text);
  }

  private add(curve: Curve): void {
    if (this.curves.add(curve)) this.renew();
    else
      this.form.say(
        this.curves.chosen.length < MOST ? "it is plotted already" : `${MOST} are plotted already`,
      );
  }

  private renew(): void {
    this.send({ plot: this.curves.chosen });
    this.draw();
  }

  private draw(): void {
    if (this.element.hidden) return;
    const now = Date.now();
    const { marks } = this.history;
    const target = this.targets.some((_, i) => targetKey(i) === this.choice.value);
    const run = (target ? TARGET_FIGURES : FIGURES).map((figure) => chartOf(this.chart(figure), marks, now));
    const chosen = this.curves.chosen.map((curve) => this.curve(curve, marks, now));
    this.plots.replaceChildren(...chosen, ...run);
    const lines = marks.slice(-LINES).reverse();
    this.log.replaceChildren(...lines.map(lineOf));
  }

  private chart(figure: Figure): Chart {
    const [title, unit, factor] = TITLES[figure];
    const found = this.history.points(this.choice.value, figure);
    const points = found.map(({ time, value }) => ({ time, value: value === null ? null : factor * value }));
    return { title, unit, points, fromZero: true };
  }

  private curve(curve: Curve, marks: Mark[], now: number): HTMLElement {
    const title = nameOf(curve);
    const points = this.curves.points(curve, now);
    const made = chartOf({ title, unit: unitOf(curve, this.figures), points, fromZero: false }, marks, now);
    const onclick = () => {
      this.curves.remove(curve);
      this.renew();
    };
    const button = make("button", "×", { type: "button", onclick });
    button.setAttribute("aria-label", `plot ${title} no more`);
    made.append(button);
    return made;
  }
}

function lineOf({ time, text, fault }: Mark): HTMLElement {
  const line = make("li", "", { className: fault ? "fault" : "" });
  line.append(make("time", new Date(time).toLocaleTimeString([], { hour12: false })), text);
  return line;
}
