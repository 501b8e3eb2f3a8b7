// The cards of the whole graph, or of those within one sub-graph, and the lines between them.

import { make } from "../elements/make.ts";
import type { EdgeStatus } from "../messages/run.ts";
import type { EdgePlan } from "../messages/scene.ts";
import type { Card } from "./card.ts";
import { linksOf } from "./links.ts";
import { standings, steps } from "./ranks.ts";
import { Wires } from "./wires.ts";

export class Drawing {
  readonly element = make("div", "", { className: "area" });
  private readonly list = make("ol");
  private readonly wires = new Wires(this.element, this.list);
  private readonly cards = new Map<string, Card>();

  constructor() {
    this.element.append(this.list);
  }

  clear(): void {
    this.cards.clear();
    this.list.replaceChildren();
  }

  add(name: string, card: Card): void {
    this.cards.set(name, card);
    this.list.append(card.item);
  }

  // Gives the cards their places.
  arrange(plan: EdgePlan[]): void {
    const links = linksOf(plan, [], this.cardOf()).map(({ from, to }): [string, string] => [from, to]);
    const found = standings([...this.cards.keys()], links);
    const wide = [...this.cards].filter(([, card]) => card.wide).map(([name]) => name);
    const downwards = steps(found, new Set(wide));
    const filled = [...found.values()].map(({ rank }) => rank);
    for (const [name, standing] of found) {
      const step = downwards.get(name);
      const alone = filled.filter((rank) => rank === standing.rank).length === 1;
      if (step) this.cards.get(name)?.place(standing, alone, step);
    }
    const most = (values: number[]) => `${Math.max(0, ...values) + 1}`;
    this.list.style.setProperty("--rows", most([...found.values()].map(({ row }) => row)));
    this.list.style.setProperty("--columns", most([...downwards.values()].map(({ column }) => column)));
  }

  // edges: their newest figures; upright: whether the graph runs downwards.
  draw(plan: EdgePlan[], edges: EdgeStatus[], upright: boolean): void {
    if (!this.element.checkVisibility()) return;
    const outlines = new Map([...this.cards].map(([name, card]) => [name, card.outline]));
    this.wires.draw(outlines, linksOf(plan, edges, this.cardOf()), upright);
  }

  // Of each stage its card; "" of stages elsewhere.
  private cardOf(): (stage: string) => string {
    const of = new Map<string, string>();
    for (const [name, { members }] of this.cards) for (const stage of members) of.set(stage, name);
    return (stage) => of.get(stage) ?? "";
  }
}
