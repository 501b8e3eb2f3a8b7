// A tile with a name, that says how old what it shows is.
import { make } from "../elements/make.ts";
import type { StageStatus, State } from "../messages/run.ts";

const SILENT_MS = 2000; // longer without anything new, what is shown is old

export abstract class Tile {
  readonly figure = make("figure", "", { className: "dark" });
  protected readonly canvas = make("canvas");
  protected readonly kind: HTMLElement;
  private readonly note = make("b");
  private absent = ""; // since when its source is
  private state: State | undefined;
  private shown: number | undefined;
  private waiting = false;

  constructor(name: string, kind: string) {
    const caption = make("figcaption", name);
    this.kind = make("small", kind);
    caption.append(this.kind, this.note);
    this.figure.append(this.canvas, caption);
  }

  protected abstract draw(): void;

  // What its source is doing.
  tell({ state, age_s }: StageStatus): void {
    this.state = state;
    this.absent = state === "absent" ? `absent${age_s === null ? "" : ` ${age_s.toFixed(0)} s`}` : "";
    this.look();
  }

  // Something new is shown.
  renew(): void {
    this.shown = performance.now();
    this.figure.classList.remove("dark");
  }

  // Says whether it is one of now.
  look(): void {
    const silent = this.shown === undefined || this.state === "over" ? 0 : performance.now() - this.shown;
    const old = silent > SILENT_MS ? `${(silent / 1000).toFixed(0)} s old` : "";
    this.note.textContent = this.absent || old;
    this.figure.classList.toggle("absent", this.state === "absent");
    this.figure.classList.toggle("old", old !== "");
  }

  // Draws before the next frame of the browser, once for all that came until then.
  redraw(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }
}

// The pen of a canvas.
export function penOf(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const pen = canvas.getContext("2d");
  if (pen === null) throw new Error("this browser draws nothing");
  return pen;
}
