// Each target by name and colour, where it is and how well that is known.
import { make } from "../elements/make.ts";
import type { TrackColumns } from "../messages/message_views.ts";
import type { TargetData } from "../messages/scene.ts";
import type { Triple } from "../messages/triple.ts";

const SILENT_MS = 2000; // longer without a word, the places that are shown are old

export class Legend {
  private rows: { row: HTMLElement; place: HTMLElement }[] = [];
  private heard: number | undefined;
  private readonly list: HTMLElement;

  constructor(list: HTMLElement) {
    this.list = list;
  }

  show(targets: TargetData[]): void {
    this.rows = targets.map(({ name, color }) => {
      const row = make("li");
      const dot = make("i");
      dot.style.background = color;
      dot.style.boxShadow = `0 0 10px ${color}`;
      const place = make("span");
      row.append(dot, name, place);
      row.dataset.state = "lost";
      return { row, place };
    });
    this.list.replaceChildren(...this.rows.map(({ row }) => row));
  }

  // How old the places are, where they are.
  look(): void {
    const silent = this.heard === undefined ? 0 : performance.now() - this.heard;
    if (silent > SILENT_MS) this.list.dataset.old = `these places are ${(silent / 1000).toFixed(0)} s old`;
    else delete this.list.dataset.old;
  }

  tracks({ target, state, xyz }: TrackColumns): void {
    this.heard = performance.now();
    const known = new Map(target.map((t, i) => [t, i]));
    this.rows.forEach(({ row, place }, t) => {
      const i = known.get(t);
      row.dataset.state = i === undefined ? "lost" : state[i];
      place.textContent = i === undefined ? "lost" : placeOf(xyz[i], state[i]);
    });
  }
}

// In columns, whatever the signs.
function placeOf(xyz: Triple, state: string): string {
  const columns = xyz.map((v) => (v < 0 ? "" : "\u2007") + v.toFixed(2).replace("-", "\u2212"));
  return `${columns.join("  ")} m${state === "tracked" ? "" : `  ${state}`}`;
}
