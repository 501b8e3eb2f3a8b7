// A tile with a name, that says how old what it shows is.
import { make } from "./make.js";

const SILENT_MS = 2000; // longer without anything new, what is shown is old

export class Tile {
  constructor(name, kind) {
    this.absent = ""; // since when its source is
    this.figure = make("figure", "", { className: "dark" });
    this.canvas = make("canvas");
    this.note = make("b");
    const caption = make("figcaption", name);
    this.kind = make("small", kind);
    caption.append(this.kind, this.note);
    this.figure.append(this.canvas, caption);
  }

  // What its source is doing.
  tell({ state, age_s }) {
    this.state = state;
    this.absent = state === "absent" ? `absent${age_s === null ? "" : ` ${age_s.toFixed(0)} s`}` : "";
    this.look();
  }

  // Something new is shown.
  renew() {
    this.shown = performance.now();
    this.figure.classList.remove("dark");
  }

  // Says whether it is one of now.
  look() {
    const silent = this.shown === undefined || this.state === "over" ? 0 : performance.now() - this.shown;
    const old = silent > SILENT_MS ? `${(silent / 1000).toFixed(0)} s old` : "";
    this.note.textContent = this.absent || old;
    this.figure.classList.toggle("absent", this.state === "absent");
    this.figure.classList.toggle("old", old !== "");
  }

  // Draws before the next frame of the browser, once for all that came until then.
  redraw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }
}
