// What is absent or was not heard lately, across the page in the colour of a fault.
import { make } from "../elements/make.ts";

const SILENT_MS = 2000; // the run's figures come twice a second

export class Faults {
  over = false;
  private ofRun: string[] = [];
  private heard = performance.now();
  private shown = "";
  private readonly list: HTMLElement;

  constructor(list: HTMLElement) {
    this.list = list;
  }

  // faults: what the run tells of its hosts and workers.
  take(faults: string[]): void {
    this.ofRun = faults;
    this.heard = performance.now();
  }

  // Nothing more is to be heard; faults: why, where that is one.
  end(faults: string[]): void {
    this.over = true;
    this.ofRun = faults;
  }

  // Shows what there is by the clock of this browser; whether nothing is wrong.
  show(): boolean {
    const silent = this.over ? 0 : performance.now() - this.heard;
    const own = silent > SILENT_MS ? [silence(silent)] : [];
    const lines = [...own, ...this.ofRun];
    if (lines.join() !== this.shown) this.list.replaceChildren(...lines.map((line) => make("li", line)));
    this.shown = lines.join();
    this.list.hidden = lines.length === 0;
    document.body.classList.toggle("old", own.length > 0 || (this.over && this.ofRun.length > 0));
    return lines.length === 0;
  }
}

function silence(ms: number): string {
  return `this page has heard nothing of the run for ${(ms / 1000).toFixed(0)} s: what it shows is old`;
}
