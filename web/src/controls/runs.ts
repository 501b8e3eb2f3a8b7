// The list of the runs in reach: each with a link to its page, or a button that begins one.

import { make } from "../elements/make.ts";
import type { Answer } from "../messages/messages.ts";
import type { Ask, OpenRequest } from "../messages/requests.ts";
import type { ListedRun } from "../messages/run.ts";
import { clock } from "../words/amounts.ts";

const LOOK_MS = 3000; // between two looks while the list is open

export interface RunsParts {
  element: HTMLElement;
  button: HTMLButtonElement;
  list: HTMLElement;
}

export class Runs {
  private readonly parts: RunsParts;
  private readonly send: Ask<OpenRequest>;
  private timer = 0;

  constructor(parts: RunsParts, send: Ask<OpenRequest>) {
    this.parts = parts;
    this.send = send;
    parts.button.onclick = () => this.toggle();
  }

  // others: whether this page tells of other runs.
  show(others: boolean): void {
    this.parts.element.hidden = !others;
  }

  answer({ text, ok }: Answer): void {
    if (ok) void this.look();
    else this.parts.list.replaceChildren(make("li", text, { className: "bad" }));
  }

  private toggle(): void {
    const { button, list } = this.parts;
    list.hidden = !list.hidden;
    button.setAttribute("aria-expanded", `${!list.hidden}`);
    clearInterval(this.timer);
    if (list.hidden) return;
    list.replaceChildren(make("li", "…"));
    void this.look();
    this.timer = window.setInterval(() => void this.look(), LOOK_MS);
  }

  private async look(): Promise<void> {
    const answer = await fetch("/runs").catch(() => null);
    if (!answer?.ok) return;
    const runs: ListedRun[] = await answer.json();
    this.parts.list.replaceChildren(...runs.map((run) => this.row(run)));
  }

  private row(run: ListedRun): HTMLElement {
    const row = make("li");
    row.append(make("b", run.graph), make("span", about(run)), this.way(run));
    row.title = run.run;
    return row;
  }

  private way(run: ListedRun): HTMLElement {
    if (run.shown) return make("em", "this page");
    if (run.page) return make("a", "page", { href: run.page });
    const button = make("button", "open", { type: "button" });
    button.onclick = () => {
      button.disabled = true;
      this.send({ open: run.run });
    };
    return button;
  }
}

// What is known of a run, in one line.
export function about({ state, hosts, owner, frames, age_s }: ListedRun): string {
  const known = [
    state,
    hosts.join(", "),
    owner,
    frames === null ? "" : `${frames} frames`,
    age_s === null ? "" : clock(age_s),
  ];
  return known.filter(Boolean).join(" · ");
}
