"""A plan as an SVG picture: workers are frames, stages boxes, edges coloured by their kind."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from html import escape

from followspot.graph.outline import Box, Line, Outline, outline
from followspot.graph.plan import Plan

_WIDTH, _HEIGHT = 150, 44
"""Of a box, px."""
_GAP_X, _GAP_Y = 60, 26
_MARGIN = 24
_TITLE = 22
"""Height of a worker's title, px."""
_COLORS = {"reference": "#6b7280", "ring": "#0f766e", "zenoh": "#c2410c"}


@dataclass(frozen=True)
class _Layout:
    """Upper left corners of boxes, top and bottom of workers, size of the picture; px."""

    corner: dict[Box, tuple[int, int]]
    rows: dict[str, tuple[int, int]]
    width: int
    height: int


def svg(plan: Plan) -> str:
    """The picture as the text of an SVG file."""
    found = outline(plan)
    layout = _layout(plan, found)
    frames = [_frame(plan, worker, layout) for worker in layout.rows]
    lines = [_curve(line, layout) for line in found.lines]
    boxes = [_box(box, layout) for box in found.boxes]
    legend = [_legend(index, kind, layout) for index, kind in enumerate(_COLORS)]
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{layout.width}" height="{layout.height}"'
        f' viewBox="0 0 {layout.width} {layout.height}" font-family="sans-serif" font-size="12">'
    )
    title = f"<title>{escape(plan.graph)} in {escape(plan.room.name)}</title>"
    ground = f'<rect width="{layout.width}" height="{layout.height}" fill="white"/>'
    return "\n".join([head, title, ground, *frames, *lines, *boxes, *legend, "</svg>\n"])


def _layout(plan: Plan, found: Outline) -> _Layout:
    """Columns from left to right as the messages flow, one row of boxes per worker."""
    corner: dict[Box, tuple[int, int]] = {}
    rows: dict[str, tuple[int, int]] = {}
    top = _MARGIN
    for worker in plan.workers:
        filled: dict[int, int] = defaultdict(int)
        for box in (box for box in found.boxes if box.worker == worker.name):
            x = 2 * _MARGIN + box.column * (_WIDTH + _GAP_X)
            corner[box] = (x, top + _TITLE + _GAP_Y // 2 + filled[box.column] * (_HEIGHT + _GAP_Y))
            filled[box.column] += 1
        bottom = top + _TITLE + max(filled.values(), default=1) * (_HEIGHT + _GAP_Y)
        rows[worker.name] = (top, bottom)
        top = bottom + _MARGIN
    right = max((x for x, _ in corner.values()), default=0) + _WIDTH
    return _Layout(corner, rows, right + 2 * _MARGIN, top + _TITLE)


def _frame(plan: Plan, worker: str, layout: _Layout) -> str:
    top, bottom = layout.rows[worker]
    host = next(planned.host for planned in plan.workers if planned.name == worker)
    title = f"worker {worker}" + (f" on {host}" if host else "")
    return (
        f'<rect x="{_MARGIN}" y="{top}" width="{layout.width - 2 * _MARGIN}" height="{bottom - top}" rx="8"'
        f' fill="#f8fafc" stroke="#94a3b8"/>'
        f'<text x="{_MARGIN + 10}" y="{top + 16}" fill="#475569">{escape(title)}</text>'
    )


def _box(box: Box, layout: _Layout) -> str:
    x, y = layout.corner[box]
    count = f" × {len(box.cameras)}" if len(box.cameras) > 1 else ""
    return (
        f"<g><title>{escape(' '.join(box.cameras) or box.group)}</title>"
        f'<rect x="{x}" y="{y}" width="{_WIDTH}" height="{_HEIGHT}" rx="5" fill="white" stroke="#1e293b"/>'
        f'<text x="{x + 10}" y="{y + 18}" font-weight="bold">{escape(box.group)}{count}</text>'
        f'<text x="{x + 10}" y="{y + 35}" fill="#475569">{escape(box.uses)}</text></g>'
    )


def _curve(line: Line, layout: _Layout) -> str:
    """From the right of a box to the left of the next; edges that lead back pass below the boxes."""
    (x0, y0), (x1, y1) = layout.corner[line.start], layout.corner[line.end]
    if line.back:
        x0, y0, x1, y1 = x0 + _WIDTH // 2, y0 + _HEIGHT, x1 + _WIDTH // 2, y1 + _HEIGHT
        path = f"M{x0},{y0} C{x0},{y0 + _GAP_Y} {x1},{y1 + _GAP_Y} {x1},{y1}"
    else:
        x0, y0, y1 = x0 + _WIDTH, y0 + _HEIGHT // 2, y1 + _HEIGHT // 2
        half = (x1 - x0) // 2
        path = f"M{x0},{y0} C{x0 + half},{y0} {x1 - half},{y1} {x1},{y1}"
    dash = ' stroke-dasharray="5 4"' if line.delay else ""
    name = f"{line.start.group}.{line.port} -> {line.end.group}.{line.input}: {line.way} × {line.count}"
    return (
        f'<path d="{path}" fill="none" stroke="{_COLORS[line.kind]}" stroke-width="1.5"{dash}>'
        f"<title>{escape(name)}</title></path>"
        f'<circle cx="{x1}" cy="{y1}" r="3" fill="{_COLORS[line.kind]}"/>'
    )


def _legend(index: int, kind: str, layout: _Layout) -> str:
    x, y = 2 * _MARGIN + index * 120, layout.height - _MARGIN // 2
    return (
        f'<line x1="{x}" y1="{y - 4}" x2="{x + 26}" y2="{y - 4}" stroke="{_COLORS[kind]}" stroke-width="2"/>'
        f'<text x="{x + 32}" y="{y}">{kind}</text>'
    )
