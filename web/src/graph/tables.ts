// The instances of an open card, and its edges, as tables.

import { make } from "../elements/make.ts";
import type { EdgeStatus, StageStatus } from "../messages/run.ts";
import { isFault, LOSSES, lasting, number } from "../words/figures.ts";

type Cell = string | number | HTMLElement;
const OUTCOMES = ["delivered", "dropped", "late", "unmatched", "invalid", "lost", "in_flight"] as const;
const COUNTS = ["produced", "away", "sent", ...OUTCOMES] as const;
const isLoss = (name: string): boolean => LOSSES.some((loss) => loss === name);

// old: of each row, whether it is one of a fault.
export function table(head: string[], rows: Cell[][], old: boolean[] = []): HTMLTableElement {
  const element = make("table");
  const line = (tag: "th" | "td", cells: Cell[], className: string): HTMLTableRowElement => {
    const row = make("tr", "", { className });
    row.append(...cells.map((cell) => (cell instanceof HTMLElement ? cell : make(tag, cell))));
    return row;
  };
  element.append(line("th", head, ""), ...rows.map((cells, i) => line("td", cells, old[i] ? "fault" : "")));
  return element;
}

export function stageTable(stages: StageStatus[]): HTMLTableElement {
  const load = (s: StageStatus) => (s.load === null ? "–" : `${(100 * s.load).toFixed(0)} %`);
  const rows = stages.map((s) => [
    s.stage,
    s.worker,
    lasting(s),
    waits(s),
    number(s.rate),
    load(s),
    s.fired,
    s.skipped,
    s.restarts,
  ]);
  const head = ["stage", "worker", "state", "on", "per second", "load", "fired", "skipped", "restarts"];
  return table(
    head,
    rows,
    stages.map(({ state }) => isFault(state)),
  );
}

export function edgeTable(edges: EdgeStatus[]): HTMLTableElement {
  const failed = edges.some(({ error }) => error);
  const lossy = (value: string | number) => make("td", value, { className: "lossy" });
  const rows = edges.map((edge) => [
    `${edge.from} → ${edge.to}`,
    edge.kind,
    number(edge.rate),
    number(edge.p50_ms),
    number(edge.p95_ms),
    ...COUNTS.map((name) => (isLoss(name) && edge[name] ? lossy(edge[name]) : edge[name])),
    ...(failed ? [lossy(edge.error)] : []),
  ]);
  const counts = COUNTS.map((name) => name.replace("_", " "));
  const head = ["edge", "kind", "per second", "p50 ms", "p95 ms", ...counts];
  return table(
    [...head, ...(failed ? ["last error"] : [])],
    rows,
    edges.map(({ old }) => old),
  );
}

function waits({ state, on }: StageStatus): string {
  const first = on[0]?.split(" -> ")[state === "sending" ? 1 : 0] ?? "";
  return on.length > 1 ? `${first} +${on.length - 1}` : first;
}
