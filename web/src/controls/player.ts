// The buttons that pause a replay, let it go on, and let it take one step.
import type { Answer } from "../messages/messages.ts";
import type { Ask, Hold } from "../messages/requests.ts";
import type { StageStatus } from "../messages/run.ts";

const STEP = 1; // capture times of the first camera

export interface PlayerParts {
  element: HTMLElement;
  pause: HTMLButtonElement;
  step: HTMLButtonElement;
  reached: HTMLElement;
}

export class Player {
  private paused = false;
  private readonly parts: PlayerParts;
  private readonly send: Ask<Hold>;

  constructor(parts: PlayerParts, send: Ask<Hold>) {
    this.parts = parts;
    this.send = send;
    parts.pause.onclick = () => this.ask(this.paused ? "resume" : "pause");
    parts.step.onclick = () => this.ask("step");
  }

  // replay: whether this page may pause the run.
  show(replay: boolean): void {
    this.parts.element.hidden = !replay;
  }

  // stages: the run's, with their states; returns whether the run is paused.
  update(stages: StageStatus[]): boolean {
    this.paused = stages.some(({ state }) => state === "paused");
    this.parts.pause.textContent = this.paused ? "resume" : "pause";
    return this.paused;
  }

  answer({ text }: Answer): void {
    this.parts.reached.textContent = text;
  }

  private ask(hold: Hold["hold"]): void {
    this.parts.reached.textContent = "…";
    this.send({ hold, count: STEP });
  }
}
