// The time line of a recording: where it stands, a button that plays it, and any moment by a drag.

import type { Position } from "../messages/messages.ts";
import type { Ask, SeekRequest } from "../messages/requests.ts";
import type { Span } from "../messages/scene.ts";
import { clock } from "../words/amounts.ts";

export interface ScrubberParts {
  element: HTMLElement;
  play: HTMLButtonElement;
  line: HTMLInputElement;
  moment: HTMLElement;
}

export class Scrubber {
  private readonly parts: ScrubberParts;
  private readonly send: Ask<SeekRequest>;
  private playing = false;
  private held = false; // whether the line is being dragged
  private span: Span = { begin: 0, end: 0 };

  constructor(parts: ScrubberParts, send: Ask<SeekRequest>) {
    this.parts = parts;
    this.send = send;
    parts.play.onclick = () => send({ seek: null, play: !this.playing });
    parts.line.oninput = () => this.seek();
    parts.line.onpointerdown = () => {
      this.held = true;
    };
    parts.line.onchange = () => {
      this.held = false;
    };
  }

  show(recorded: Span | null): void {
    this.parts.element.hidden = recorded === null;
    if (recorded === null) return;
    this.span = recorded;
    this.parts.line.max = `${recorded.end - recorded.begin}`;
  }

  update({ at, playing }: Position): void {
    this.playing = playing;
    this.parts.play.textContent = playing ? "pause" : "play";
    if (!this.held) this.parts.line.value = `${at - this.span.begin}`;
    this.parts.moment.textContent = said(at - this.span.begin, this.span);
  }

  private seek(): void {
    const after = Number(this.parts.line.value);
    this.parts.moment.textContent = said(after, this.span);
    this.send({ seek: this.span.begin + after, play: this.playing && !this.held });
  }
}

// A moment, s after the beginning, and how long the recording is.
export function said(after: number, { begin, end }: Span): string {
  const tenths = Math.floor((after * 10) % 10);
  return `${clock(after)}.${tenths} of ${clock(end - begin)}`;
}
