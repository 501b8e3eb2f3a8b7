"""Figures of persons' poses, compared: one row a variant, for each room and for all."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from followspot.tables.terminal import table
from followspot_accuracy import PersonsScore
from followspot_compare.columns import Column, finite, mean

Scores = Sequence[PersonsScore]
"""One for each room."""
Statistic = Callable[[Sequence[float]], float]


def slowest(times: Sequence[float]) -> float:
    """The longest; NaN for none."""
    return max((t for t in times if math.isfinite(t)), default=math.nan)


def _person(
    key: str, heading: str, form: str, of: Callable[[PersonsScore], float], over: Statistic = mean
) -> Column:
    """of: the figure for all persons of a room; over: combines rooms."""
    return Column(key, heading, form, lambda scores: over([of(score) for score in scores]))


PERSON_COLUMNS = (
    _person("coverage_percent", "coverage", "{:.1f} %", lambda s: 100 * s.overall.coverage),
    _person("direction_median_deg", "direction", "{:.2f}°", lambda s: s.overall.direction_deg.median),
    _person("distance_sigma_m", "distance sigma", "{:.2f} m", lambda s: s.overall.distance_m.sigma),
    _person("height_sigma_cm", "height sigma", "{:.1f} cm", lambda s: s.overall.height_cm.sigma),
    _person("position_median_cm", "position", "{:.1f} cm", lambda s: s.overall.position_cm.median),
    _person("position_p95_cm", "p95", "{:.1f} cm", lambda s: s.overall.position_cm.p95),
    _person("torso_median_deg", "torso", "{:.1f}°", lambda s: s.overall.torso.median_deg),
    _person("torso_within_22_percent", "<22.5°", "{:.1f} %", lambda s: 100 * s.overall.torso.within_22),
    _person("torso_within_45_percent", "<45°", "{:.1f} %", lambda s: 100 * s.overall.torso.within_45),
    _person("torso_flipped_percent", "flipped", "{:.1f} %", lambda s: 100 * s.overall.torso.flipped),
    _person("pan_median_deg", "pan", "{:.1f}°", lambda s: s.overall.pan_median_deg),
    _person("tilt_median_deg", "tilt", "{:.1f}°", lambda s: s.overall.tilt_median_deg),
    _person("switches", "switches", "{:.0f}", lambda s: s.overall.identity_switches, sum),
    _person("false_percent", "false", "{:.1f} %", lambda s: 100 * s.surplus.false_share),
    _person("duplicates", "second poses", "{:.0f}", lambda s: s.surplus.duplicate_rows, sum),
    _person("acquire_s", "acquire", "{:.1f} s", lambda s: slowest(s.overall.acquire_s), slowest),
    _person("vanish_s", "vanish", "{:.1f} s", lambda s: slowest(s.overall.vanish_s), slowest),
)
"""In the order of the table. Several rooms: the mean, but the sum of switches and of second poses, and the
slowest time to acquire and to vanish."""

ByRoom = Mapping[str, PersonsScore]
"""Room -> scores of one variant."""


def persons_text(variants: Mapping[str, ByRoom]) -> str:
    """A group of rows per room and for all of them, for variants that have scores."""
    rows: list[tuple[str, ...]] = []
    for title, group in _groups(variants):
        rows.append((title, *[""] * len(PERSON_COLUMNS)))
        rows += [(f"  {name}", *(c.cell(scores) for c in PERSON_COLUMNS)) for name, scores in group.items()]
    return "poses against ground truth\n" + table(("", *(c.heading for c in PERSON_COLUMNS)), rows)


def persons_means(variants: Mapping[str, ByRoom]) -> dict[str, dict[str, Any]]:
    """Every figure over all rooms, per variant; NaN becomes null."""
    return {
        name: {c.key: finite(c.of(list(rooms.values()))) for c in PERSON_COLUMNS}
        for name, rooms in variants.items()
        if rooms
    }


def _groups(variants: Mapping[str, ByRoom]) -> Iterator[tuple[str, dict[str, Scores]]]:
    rooms = list(dict.fromkeys(room for by_room in variants.values() for room in by_room))
    for room in rooms:
        yield room, {name: [by_room[room]] for name, by_room in variants.items() if room in by_room}
    if len(rooms) > 1:
        yield "all rooms", {name: list(by_room.values()) for name, by_room in variants.items() if by_room}
