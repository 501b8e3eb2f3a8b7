// The button that saves the last seconds of a run that keeps them, and what it holds.

import type { Answer, Kept, Moment } from "../messages/messages.ts";
import type { Ask, MarkRequest } from "../messages/requests.ts";
import { size } from "../words/amounts.ts";

export interface MarkerParts {
  element: HTMLElement;
  mark: HTMLButtonElement;
  note: HTMLInputElement;
  marked: HTMLElement;
}

export class Marker {
  private readonly parts: MarkerParts;
  private readonly send: Ask<MarkRequest>;

  constructor(parts: MarkerParts, send: Ask<MarkRequest>) {
    this.parts = parts;
    this.send = send;
    parts.mark.onclick = () => this.ask();
    parts.note.onkeydown = ({ key }) => {
      if (key === "Enter" && !parts.mark.disabled) this.ask();
    };
  }

  update(kept: Kept): void {
    const { element, mark, marked } = this.parts;
    element.hidden = false;
    mark.title = `saves the last ${kept.seconds} s and the next 5 s`;
    if (mark.disabled) return; // the answer comes first
    const [moment] = kept.moments;
    element.dataset.state = moment?.state ?? "";
    marked.textContent = moment ? said(moment) : held(kept);
    marked.title = [moment?.file, ...(moment?.notes ?? []), held(kept)].filter(Boolean).join("\n");
  }

  answer({ text, ok }: Answer): void {
    this.parts.mark.disabled = false;
    this.parts.element.dataset.state = ok ? "open" : "failed";
    this.parts.marked.textContent = text;
    if (ok) this.parts.note.value = "";
  }

  // Save the moment, with the note that was typed.
  private ask(): void {
    const { mark, note, marked } = this.parts;
    mark.disabled = true;
    marked.textContent = "…";
    this.send({ mark: note.value.trim() });
  }
}

// What is in memory: the seconds of the port of which there are the fewest.
export function held({ held, bytes, lost }: Kept): string {
  const missing = lost ? ` · ${lost} missing` : "";
  return `holds ${held.toFixed(0)} s · ${size(bytes)}${missing}`;
}

// What became of the newest mark.
export function said({ file, state, seconds, bytes, lost, problem }: Moment): string {
  if (state === "failed") return `not saved: ${problem.split("\n")[0]}`;
  const name = file.split("/").pop();
  if (state === "open") return `saving ${name}`;
  return `${name} · ${seconds.toFixed(1)} s · ${size(bytes)}${lost ? ` · ${lost} missing` : ""}`;
}
