"""Figures of persons' poses, compared: one row a variant, for each room and for all."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from followspot.accuracy import PersonsScore
from followspot.tables import table
from followspot_compare.columns import mean

Scores = Sequence[PersonsScore]
"""One for each room."""
Statistic = Callable[[Sequence[float]], float]


@dataclass(frozen=True)
class PersonColumn:
    """A figure. of: its value for all persons of a room; over: what many rooms have together."""

    key: str
    heading: str
    form: str
    of: Callable[[PersonsScore], float]
    over: Statistic = mean

    def value(self, scores: Scores) -> float:
        """The figure of some rooms; NaN if nothing was measured."""
        return self.over([self.of(score) for score in scores])

    def cell(self, scores: Scores) -> str:
        """The value as text, a dash for NaN."""
        value = self.value(scores)
        return self.form.format(value) if math.isfinite(value) else "-"


def slowest(times: Sequence[float]) -> float:
    """The longest; NaN for none."""
    return max((t for t in times if math.isfinite(t)), default=math.nan)


PERSON_COLUMNS = (
    PersonColumn("coverage_percent", "coverage", "{:.1f} %", lambda s: 100 * s.overall.coverage),
    PersonColumn("direction_median_deg", "direction", "{:.2f}°", lambda s: s.overall.direction_deg.median),
    PersonColumn("distance_sigma_m", "distance sigma", "{:.2f} m", lambda s: s.overall.distance_m.sigma),
    PersonColumn("height_sigma_cm", "height sigma", "{:.1f} cm", lambda s: s.overall.height_cm.sigma),
    PersonColumn("position_median_cm", "position", "{:.1f} cm", lambda s: s.overall.position_cm.median),
    PersonColumn("position_p95_cm", "p95", "{:.1f} cm", lambda s: s.overall.position_cm.p95),
    PersonColumn("torso_median_deg", "torso", "{:.1f}°", lambda s: s.overall.torso.median_deg),
    PersonColumn("torso_within_22_percent", "<22.5°", "{:.1f} %", lambda s: 100 * s.overall.torso.within_22),
    PersonColumn("torso_within_45_percent", "<45°", "{:.1f} %", lambda s: 100 * s.overall.torso.within_45),
    PersonColumn("torso_flipped_percent", "flipped", "{:.1f} %", lambda s: 100 * s.overall.torso.flipped),
    PersonColumn("pan_median_deg", "pan", "{:.1f}°", lambda s: s.overall.pan_median_deg),
    PersonColumn("tilt_median_deg", "tilt", "{:.1f}°", lambda s: s.overall.tilt_median_deg),
    PersonColumn("switches", "switches", "{:.0f}", lambda s: s.overall.identity_switches, sum),
    PersonColumn("false_percent", "false", "{:.1f} %", lambda s: 100 * s.surplus.false_share),
    PersonColumn("duplicates", "second poses", "{:.0f}", lambda s: s.surplus.duplicate_rows, sum),
    PersonColumn("acquire_s", "acquire", "{:.1f} s", lambda s: slowest(s.overall.acquire_s), slowest),
    PersonColumn("vanish_s", "vanish", "{:.1f} s", lambda s: slowest(s.overall.vanish_s), slowest),
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
        name: {c.key: _finite(c.value(list(rooms.values()))) for c in PERSON_COLUMNS}
        for name, rooms in variants.items()
        if rooms
    }


def _groups(variants: Mapping[str, ByRoom]) -> Iterator[tuple[str, dict[str, Scores]]]:
    rooms = list(dict.fromkeys(room for by_room in variants.values() for room in by_room))
    for room in rooms:
        yield room, {name: [by_room[room]] for name, by_room in variants.items() if room in by_room}
    if len(rooms) > 1:
        yield "all rooms", {name: list(by_room.values()) for name, by_room in variants.items() if by_room}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
