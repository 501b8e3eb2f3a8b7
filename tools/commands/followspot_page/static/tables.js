// The instances of an open card, and its edges, as tables.
import { FAULTS, LOSSES, lasting, number } from "./figures.js";
import { make } from "./make.js";

// old: of each row, whether it is one of a fault.
export function table(head, rows, old = []) {
  const element = make("table");
  const line = (tag, cells, className) => {
    const row = make("tr", "", { className });
    row.append(...cells.map((cell) => (cell instanceof Node ? cell : make(tag, cell))));
    return row;
  };
  element.append(line("th", head, ""), ...rows.map((cells, i) => line("td", cells, old[i] ? "fault" : "")));
  return element;
}

export function stageTable(stages) {
  const load = (s) => (s.load === null ? "–" : `${(100 * s.load).toFixed(0)} %`);
  const rows = stages.map((s) => [s.stage, s.worker, lasting(s), waits(s), number(s.rate), load(s), s.fired, s.skipped, s.restarts]);
  return table(["stage", "worker", "state", "on", "per second", "load", "fired", "skipped", "restarts"], rows, stages.map(({ state }) => FAULTS.includes(state)));
}

export function edgeTable(edges) {
  const counts = ["produced", "away", "sent", "delivered", ...LOSSES.slice(1), "in_flight"];
  const failed = edges.some(({ error }) => error);
  const rows = edges.map((edge) => [
    `${edge.from} → ${edge.to}`,
    edge.kind,
    number(edge.rate),
    number(edge.p50_ms),
    number(edge.p95_ms),
    ...counts.map((name) => make("td", edge[name], { className: LOSSES.includes(name) && edge[name] ? "lossy" : "" })),
    ...(failed ? [make("td", edge.error, { className: "lossy" })] : []),
  ]);
  const last = failed ? ["last error"] : [];
  return table(["edge", "kind", "per second", "p50 ms", "p95 ms", ...counts.map((name) => name.replace("_", " ")), ...last], rows, edges.map(({ old }) => old));
}

function waits({ state, on }) {
  const first = on[0]?.split(" -> ")[state === "sending" ? 1 : 0] ?? "";
  return on.length > 1 ? `${first} +${on.length - 1}` : first;
}
