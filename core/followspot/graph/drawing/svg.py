"""A plan as an SVG picture: workers are frames, stages boxes, edges coloured by their kind."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from followspot.graph.drawing.outline import Box, Line, outline
from followspot.graph.drawing.svg_layout import HEIGHT, MARGIN, Layout, Point, layout, text_of
from followspot.graph.plan import Plan

_COLORS = {"reference": "#6b7280", "ring": "#0f766e", "zenoh": "#c2410c"}
_BEND = 7.0
"""Radius of the bends of lines, px."""


def svg(plan: Plan, *, fold: bool = True) -> str:
    """The picture as the text of an SVG file; fold: whether a sub-graph is one box in each worker."""
    found = outline(plan, fold=fold)
    laid = layout(plan, found)
    frames = [_frame(plan, worker, laid) for worker in laid.rows]
    lines = [_line(line, corners) for line, corners in laid.routes]
    boxes = [_box(box, laid) for box in found.boxes]
    kinds = [kind for kind in _COLORS if any(line.kind == kind for line in found.lines)]
    legend = [_legend(index, kind, laid) for index, kind in enumerate(kinds)]
    size = f'width="{laid.width:g}" height="{laid.height:g}"'
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="0 0 {laid.width:g} {laid.height:g}"'
        ' font-family="sans-serif" font-size="12">'
    )
    title = f"<title>{escape(plan.graph)} in {escape(plan.room.name)}</title>"
    ground = f'<rect {size} fill="white"/>'
    return "\n".join([head, title, ground, *frames, *lines, *boxes, *legend, "</svg>\n"])


def _frame(plan: Plan, worker: str, laid: Layout) -> str:
    top, bottom = laid.rows[worker]
    host = next(planned.host for planned in plan.workers if planned.name == worker)
    title = f"worker {worker}" + (f" on {host}" if host else "")
    return (
        f'<rect x="{MARGIN}" y="{top:g}" width="{laid.width - 2 * MARGIN:g}" height="{bottom - top:g}" rx="8"'
        f' fill="#f8fafc" stroke="#94a3b8"/>'
        f'<text x="{MARGIN + 10}" y="{top + 16:g}" fill="#475569">{escape(title)}</text>'
    )


def _box(box: Box, laid: Layout) -> str:
    x, y = laid.corner[box]
    name, uses = text_of(box)
    return (
        f"<g><title>{escape(' '.join(box.members) or box.name)}</title>"
        f'<rect x="{x:g}" y="{y:g}" width="{laid.box_width:g}" height="{HEIGHT}" rx="5" fill="white"'
        f' stroke="#1e293b"/>'
        f'<text x="{x + 10:g}" y="{y + 18:g}" font-weight="bold">{escape(name)}</text>'
        f'<text x="{x + 10:g}" y="{y + 35:g}" fill="#475569">{escape(uses)}</text></g>'
    )


def _line(line: Line, corners: Sequence[Point]) -> str:
    """A line with a dot at its end; dashed if it leads to a later frame."""
    x, y = corners[-1]
    dash = ' stroke-dasharray="5 4"' if line.delay else ""
    name = f"{line.sender} -> {line.reader}: {line.shown_kind} × {line.count}"
    return (
        f'<path d="{_path(corners)}" fill="none" stroke="{_COLORS[line.kind]}" stroke-width="1.5"{dash}>'
        f"<title>{escape(name)}</title></path>"
        f'<circle cx="{x:g}" cy="{y:g}" r="3" fill="{_COLORS[line.kind]}"/>'
    )


def _path(corners: Sequence[Point]) -> str:
    """Through corners, upright or level from one to the next, with bends."""
    words = [f"M{corners[0][0]:g},{corners[0][1]:g}"]
    for before, here, after in zip(corners, corners[1:], corners[2:], strict=False):
        (x0, y0), (x1, y1) = _towards(here, before), _towards(here, after)
        words.append(f"L{x0:g},{y0:g} Q{here[0]:g},{here[1]:g} {x1:g},{y1:g}")
    return " ".join([*words, f"L{corners[-1][0]:g},{corners[-1][1]:g}"])


def _towards(here: Point, there: Point) -> Point:
    """A bend's length from here, or half of the way."""
    dx, dy = there[0] - here[0], there[1] - here[1]
    share = min(0.5, _BEND / max(abs(dx) + abs(dy), 1e-9))
    return here[0] + share * dx, here[1] + share * dy


def _legend(index: int, kind: str, laid: Layout) -> str:
    x, y = 2 * MARGIN + index * 120, laid.height - MARGIN // 2
    stroke = f'stroke="{_COLORS[kind]}" stroke-width="2"'
    return (
        f'<line x1="{x}" y1="{y - 4:g}" x2="{x + 26}" y2="{y - 4:g}" {stroke}/>'
        f'<text x="{x + 32}" y="{y:g}">{kind}</text>'
    )
