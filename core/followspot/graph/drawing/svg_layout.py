"""Places of the boxes and lines in a graph's picture; no line passes behind a box.

Columns follow the messages from left to right; each worker is a frame with rows of boxes. A line leaves its
box on the right, turns in a gap between two columns and enters on the left. One that passes over columns, or
leads back, runs in a lane of a worker's frame, above or below its boxes. Lines with one destination, or that
lead back from one port, share turns and lanes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from followspot.graph.drawing.outline import Box, Line, Outline
from followspot.graph.plan import Plan

HEIGHT = 44
"""Size of a box, px."""
MARGIN = 24
TITLE = 22
"""Height of a worker's title, px."""
_NARROWEST = 130
_LETTER = 7
"""Width of a letter, px."""
_GAP, _GAP_Y = 56, 26
_STEP = 9
"""Between two lanes, and between two turns in a gap, px."""

Point = tuple[float, float]
Place = TypeVar("Place", bound=Hashable)


@dataclass(frozen=True)
class Layout:
    """Upper left corners of boxes, their width, top and bottom of workers, corners of lines, size; px."""

    corner: Mapping[Box, Point]
    box_width: float
    rows: Mapping[str, tuple[float, float]]
    routes: Sequence[tuple[Line, Sequence[Point]]]
    width: float
    height: float


@dataclass(frozen=True)
class _Course:
    """The course of a line through the gaps between columns and the lanes along workers.

    turns: columns before which the line turns, each with a key that lines with one turn share; lane: a worker
    and whether the lane is above it, with such a key; None if the line needs none.
    """

    line: Line
    turns: tuple[tuple[int, Hashable], ...]
    lane: tuple[tuple[str, bool], Hashable] | None = None


def layout(plan: Plan, found: Outline) -> Layout:
    """Lay a folded plan out."""
    courses = [_course(line) for line in found.lines]
    gaps = _shared(turn for course in courses for turn in course.turns)
    lanes = _shared(course.lane for course in courses if course.lane is not None)
    letters = max((len(text) for box in found.boxes for text in text_of(box)), default=0)
    box_width = max(_NARROWEST, _LETTER * letters + 20)
    lefts, turn_x, right = _across(found.boxes, gaps, box_width)
    corner, rows, lane_y, bottom = _down(plan, found.boxes, lanes, lefts)
    port_y = _ports(courses, corner)
    routes = []
    for course in courses:
        line = course.line
        ys = [port_y["out", line.start, line.port], port_y["in", line.end, line.input]]
        if course.lane is not None:
            ys.insert(1, lane_y[course.lane])
        xs = [
            corner[line.start][0] + box_width,
            *(turn_x[turn] for turn in course.turns),
            corner[line.end][0],
        ]
        routes.append((line, [(x, y) for y, *ends in zip(ys, xs, xs[1:], strict=False) for x in ends]))
    return Layout(corner, box_width, rows, routes, right + MARGIN, bottom + TITLE)


def text_of(box: Box) -> tuple[str, str]:
    """Text of a box: the stage, and the plugin stage that it uses."""
    if len(box.members) == 1 and box.stages == 1:
        return f"{box.name}/{box.members[0]}", box.uses
    return box.name + (f" × {len(box.members)}" if box.members else ""), box.uses


def _course(line: Line) -> _Course:
    style = (line.kind, line.delay)
    if line.back:
        key: Hashable = (line.start, line.port, style)
        turns = ((line.start.column + 1, ("out", key)), (line.end.column, ("in", key)))
        return _Course(line, turns, ((line.start.worker, False), key))
    key = (line.end, line.input, style)
    if line.end.column == line.start.column + 1:
        return _Course(line, ((line.end.column, ("in", key)),))
    turns = ((line.start.column + 1, ("out", key)), (line.end.column, ("in", key)))
    return _Course(line, turns, ((line.end.worker, True), key))


def _shared(places: Iterable[tuple[Place, Hashable]]) -> dict[Place, list[Hashable]]:
    """The lines that share each place; lines that leave a box come before lines that enter one."""
    found: dict[Place, list[Hashable]] = {}
    for place, key in sorted(dict.fromkeys(places), key=lambda shared: _enters(shared[1])):
        found.setdefault(place, []).append(key)
    return found


def _enters(key: Hashable) -> bool:
    return isinstance(key, tuple) and key[0] == "in"


def _across(
    boxes: Sequence[Box], gaps: Mapping[int, Sequence[Hashable]], box_width: float
) -> tuple[list[float], dict[tuple[int, Hashable], float], float]:
    """Left edge of each column, place of each turn, right edge of the last gap."""
    columns = 1 + max((box.column for box in boxes), default=0)
    lefts, turn_x, x = [], {}, float(MARGIN)
    for gap in range(columns + 1):
        inner = _STEP * max(0, len(gaps.get(gap, ())) - 1)
        least = _GAP if 0 < gap < columns else MARGIN
        width = max(least, inner + MARGIN)
        for number, key in enumerate(gaps.get(gap, ())):
            turn_x[gap, key] = x + (width - inner) / 2 + _STEP * number
        x += width
        if gap < columns:
            lefts.append(x)
            x += box_width
    return lefts, turn_x, x


def _down(
    plan: Plan,
    boxes: Sequence[Box],
    lanes: Mapping[tuple[str, bool], Sequence[Hashable]],
    lefts: Sequence[float],
) -> tuple[
    dict[Box, Point], dict[str, tuple[float, float]], dict[tuple[tuple[str, bool], Hashable], float], float
]:
    """Corner of each box, top and bottom of each worker, height of each lane, bottom of the last worker."""
    corner: dict[Box, Point] = {}
    rows: dict[str, tuple[float, float]] = {}
    lane_y: dict[tuple[tuple[str, bool], Hashable], float] = {}
    top = float(MARGIN)
    for worker in (worker.name for worker in plan.workers):
        y = top + TITLE
        for number, key in enumerate(lanes.get((worker, True), ())):
            lane_y[(worker, True), key] = y + _STEP * (number + 0.5)
        y += _STEP * len(lanes.get((worker, True), ())) + _GAP_Y / 2
        filled: dict[int, int] = defaultdict(int)
        for box in (box for box in boxes if box.worker == worker):
            corner[box] = (lefts[box.column], y + filled[box.column] * (HEIGHT + _GAP_Y))
            filled[box.column] += 1
        y += max(filled.values(), default=1) * (HEIGHT + _GAP_Y) - _GAP_Y / 2
        for number, key in enumerate(lanes.get((worker, False), ())):
            lane_y[(worker, False), key] = y + _STEP * (number + 0.5)
        bottom = y + _STEP * len(lanes.get((worker, False), ()))
        rows[worker] = (top, bottom)
        top = bottom + MARGIN
    return corner, rows, lane_y, top


def _ports(courses: Sequence[_Course], corner: Mapping[Box, Point]) -> dict[tuple[str, Box, str], float]:
    """Height of each port: a straight line in the middle, others in the direction of their lines."""
    sides: dict[tuple[str, Box], dict[str, bool]] = {}
    for course in sorted(courses, key=lambda course: (course.line.back, len(course.turns))):
        line, up = course.line, course.lane is not None and course.lane[0][1]
        sides.setdefault(("out", line.start), {}).setdefault(line.port, up)
        sides.setdefault(("in", line.end), {}).setdefault(line.input, up)
    heights: dict[tuple[str, Box, str], float] = {}
    for (side, box), found in sides.items():
        first, *rest = found
        upper = [name for name in rest if found[name]]
        lower = [name for name in rest if not found[name]]
        step = min(11.0, (HEIGHT / 2 - 4.0) / max(1, len(upper), len(lower)))
        places = {first: 0.0, **{name: -step * n for n, name in enumerate(upper, 1)}}
        places |= {name: step * n for n, name in enumerate(lower, 1)}
        heights |= {(side, box, name): corner[box][1] + HEIGHT / 2 + y for name, y in places.items()}
    return heights
