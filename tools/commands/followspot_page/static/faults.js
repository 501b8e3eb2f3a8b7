// What is absent or was not heard lately, across the page in the colour of a fault.
import { make } from "./make.js";

const SILENT_MS = 2000; // the run's figures come twice a second

export class Faults {
  constructor(list) {
    this.list = list;
    this.told = [];
    this.heard = performance.now();
    this.over = false;
  }

  // faults: what the run tells of its hosts and workers.
  take(faults) {
    this.told = faults;
    this.heard = performance.now();
  }

  // Nothing more is to be heard; faults: why, where that is one.
  end(faults) {
    this.over = true;
    this.told = faults;
  }

  // Shows what there is by the clock of this browser; whether nothing is wrong.
  show() {
    const silent = this.over ? 0 : performance.now() - this.heard;
    const own = silent > SILENT_MS ? [`this page has heard nothing of the run for ${(silent / 1000).toFixed(0)} s: what it shows is old`] : [];
    const lines = [...own, ...this.told];
    if (lines.join() !== this.shown) this.list.replaceChildren(...lines.map((line) => make("li", line)));
    this.shown = lines.join();
    this.list.hidden = lines.length === 0;
    document.body.classList.toggle("old", own.length > 0 || (this.over && this.told.length > 0));
    return lines.length === 0;
  }
}
