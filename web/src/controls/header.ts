// The first line of the page: which run it is, whether it lives, and its main figures.

import { part } from "../elements/part.ts";
import type { Run } from "../messages/run.ts";
import type { Scene } from "../messages/scene.ts";
import { lossOf, slowest, span } from "../words/figures.ts";

export type Life = "running" | "paused" | "waiting" | "fault" | "ended" | "gone";

export class Header {
  private readonly graph = part("graph", HTMLElement);
  private readonly room = part("room", HTMLElement);
  private readonly life = part("life", HTMLElement);
  private readonly rate = part("rate", HTMLElement);
  private readonly fired = part("fired", HTMLElement);
  private readonly latency = part("latency", HTMLElement);
  private readonly lost = part("lost", HTMLElement);
  private readonly figures = part("figures", HTMLElement);
  private recorded = false; // whether a recording is shown instead of a run

  show({ graph, room, recorded }: Scene): void {
    this.recorded = recorded !== null;
    this.graph.textContent = graph;
    this.room.textContent = room.name;
  }

  update(run: Run, paused: boolean): void {
    this.figures.hidden = this.recorded;
    if (this.recorded) {
      this.live("ended", "recording");
      return;
    }
    const begun = run.stages.some((stage) => stage.state !== "over");
    const life = paused ? "paused" : "running";
    this.live(begun ? life : "waiting", begun ? life : "starting");
    const path = slowest(run.paths.filter(({ old }) => !old));
    const lost = lossOf(run.edges);
    this.rate.textContent = run.rate === null ? "–" : run.rate.toFixed(run.rate < 10 ? 1 : 0);
    this.fired.textContent = run.expected ? `${run.fired} / ${run.expected}` : `${run.fired}`;
    this.latency.textContent = path ? span(path) : "–";
    this.lost.textContent = `${lost}`;
    this.lost.className = lost ? "lossy" : "";
  }

  live(life: Life, text: string): void {
    this.life.dataset.life = life;
    this.life.textContent = text;
  }

  // well: whether there are no faults now.
  look(well: boolean): void {
    const { life } = this.life.dataset;
    if (life === "running" && !well) this.live("fault", "fault");
    else if (life === "fault" && well) this.live("running", "running");
    document.title = `${well ? "" : "! "}${this.graph.textContent} · followspot`;
  }
}
