"""A plan as text and as a Mermaid flow chart; `followspot.graph.drawing.svg` draws it."""

from __future__ import annotations

from collections.abc import Sequence

from followspot.graph.drawing.outline import Line, outline
from followspot.graph.plan import Plan, PlannedWorker


def title(plan: Plan) -> str:
    """The graph, its room, and how much there is of each."""
    parts = {"stage": plan.stages, "edge": plan.edges, "worker": plan.workers}
    counts = (f"{len(found)} {noun}{'s' * (len(found) != 1)}" for noun, found in parts.items())
    return f"{plan.graph} in {plan.room.name}: {', '.join(counts)}"


def text(plan: Plan, *, fold: bool = True) -> str:
    """Workers with their stages, then the edges with their kinds; fold: show each sub-graph as one line."""
    found = outline(plan, fold=fold)
    lines = [title(plan)]
    for worker in plan.workers:
        boxes = [box for box in found.boxes if box.worker == worker.name]
        rows = [(box.name, box.uses, " ".join(box.members)) for box in boxes]
        lines += ["", _title(worker), *_aligned(rows)]
    lines += ["", "edges", *_aligned(_edge_rows(found.lines))]
    if plan.budgets:
        lines += ["", "budgets", *(f"  {b.name}: {b.limit_ms:g} ms" for b in plan.budgets)]
    if not plan.live and any(edge.drops for edge in plan.edges):
        lines.append("note: no source is live, so nothing is dropped: every edge blocks")
    if any(box.stages > 1 for box in found.boxes):
        lines.append("note: sub-graphs are folded; --unfold shows their stages")
    return "\n".join([*lines, *(f"note: {note}" for note in plan.notes)])


def mermaid(plan: Plan, *, fold: bool = True) -> str:
    """A Mermaid flow chart; workers are its subgraphs, edges that lead back are dotted."""
    found = outline(plan, fold=fold)
    number = {box: f"s{index}" for index, box in enumerate(found.boxes)}
    lines = ["flowchart LR"]
    for index, worker in enumerate(plan.workers):
        lines.append(f'  subgraph w{index}["{_escaped(_title(worker))}"]')
        lines += [
            f'    {number[box]}["{_escaped(box.name)}{_times(len(box.members))}<br/>{_escaped(box.uses)}"]'
            for box in found.boxes
            if box.worker == worker.name
        ]
        lines.append("  end")
    for line in found.lines:
        arrow = "-.->" if line.delay else "-->"
        label = f"{_escaped(line.input)} · {_kind(line.shown_kind, line.count, line.delay)}"
        lines.append(f'  {number[line.start]} {arrow}|"{label}"| {number[line.end]}')
    return "\n".join(lines)


def _title(worker: PlannedWorker) -> str:
    title = f"worker {worker.name} on {worker.host}" if worker.host else f"worker {worker.name}"
    scheduling = str(worker.scheduling)
    return f"{title}, {scheduling}" if scheduling else title


def _edge_rows(lines: Sequence[Line]) -> list[tuple[str, str, str]]:
    """One row per pair of ports, kind and pair of workers, ordered by ports."""
    counts: dict[tuple[str, str], dict[tuple[str, str, int], int]] = {}
    for line in lines:
        ports = (line.sender, f"-> {line.reader}")
        apart = line.start.worker != line.end.worker
        workers = f" ({line.start.worker} to {line.end.worker})" if apart else ""
        of_ports = counts.setdefault(ports, {})
        key = (line.shown_kind, workers, line.delay)
        of_ports[key] = of_ports.get(key, 0) + line.count
    return [
        (*ports, _kind(kind, count, delay) + workers)
        for ports, of_ports in counts.items()
        for (kind, workers, delay), count in of_ports.items()
    ]


def _kind(kind: str, count: int, delay: int) -> str:
    return f"{kind}{_times(count)}" + (f", delay {delay}" if delay else "")


def _times(count: int) -> str:
    return f" × {count}" if count > 1 else ""


def _aligned(rows: list[tuple[str, str, str]]) -> list[str]:
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(2)]
    return [f"  {a:<{widths[0]}}  {b:<{widths[1]}}  {c}".rstrip() for a, b, c in rows]


def _escaped(text: str) -> str:
    """Escape for Mermaid: HTML entities with # instead of &."""
    return "".join(c if c.isalnum() or c in " ._-/·" else f"#{ord(c)};" for c in text)
