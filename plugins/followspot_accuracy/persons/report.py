"""Scores of persons as a table for people and as JSON for programs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from textwrap import dedent
from typing import Any

from followspot.tables.terminal import table
from followspot_accuracy.persons.scoring import PersonScore, PersonsScore, Spread
from followspot_accuracy.persons.tracking import Tracking

ALL = "all"
"""Stands for all persons together."""


def persons_table(score: PersonsScore) -> str:
    """A line per figure, a column per person and one for all; a dash if there was nothing to measure."""
    named = {**score.persons, ALL: score.overall} if len(score.persons) != 1 else score.persons
    head, *rows = zip(
        ("person", *HEADINGS), *((name, *_cells(one)) for name, one in named.items()), strict=True
    )
    surplus = score.surplus
    false = f"{surplus.false_rows} in {_percent(surplus.false_share)} of {surplus.frames} frames"
    return (
        f"{dedent(table(head, rows))}\n"
        f"false persons: {false}; second poses of a person: {surplus.duplicate_rows}\n"
        f"{_tracking(score.tracking)}"
    )


def persons_to_json(score: PersonsScore) -> dict[str, dict[str, Any]]:
    """The scores as JSON types, `all` with the surplus; NaN becomes null."""
    found = {name: _plain(dataclasses.asdict(one)) for name, one in score.persons.items()}
    surplus = dataclasses.asdict(score.surplus)
    whole = {
        "frames_in_all": surplus.pop("frames"),
        **surplus,
        "tracking": dataclasses.asdict(score.tracking),
    }
    return {**found, ALL: _plain({**dataclasses.asdict(score.overall), **whole})}


HEADINGS = (
    "frames half visible",
    "coverage",
    "direction: mean ± sigma",
    "  median, p95",
    "distance: mean ± sigma",
    "  median, p95",
    "height: mean ± sigma",
    "  median, p95",
    "position: median, p95",
    "torso: median",
    "  within 22.5°, 45°",
    "  flipped (over 135°)",
    "head pan, tilt: median",
    "identity switches",
    "time to acquire, slowest",
    "time to vanish, slowest",
    "returns known again",
)


def _cells(one: PersonScore) -> list[str]:
    torso = one.torso
    return [
        str(one.frames),
        _percent(one.coverage),
        *_spread(one.direction_deg, ".1f", "°"),
        *_spread(one.distance_m, ".2f", " m"),
        *_spread(one.height_cm, ".1f", " cm"),
        _spread(one.position_cm, ".1f", " cm")[1],
        _number(torso.median_deg, ".1f", "°"),
        f"{_percent(torso.within_22)}, {_percent(torso.within_45)}",
        _percent(torso.flipped),
        f"{_number(one.pan_median_deg, '.1f', '°')}, {_number(one.tilt_median_deg, '.1f', '°')}",
        str(one.identity_switches),
        _slowest(one.acquire_s),
        _slowest(one.vanish_s),
        f"{one.returns_known} of {one.returns}" if one.returns else "-",
    ]


def _spread(spread: Spread, form: str, unit: str) -> tuple[str, str]:
    if not math.isfinite(spread.mean):
        return "-", "-"
    first = f"{spread.mean:+{form}} ± {spread.sigma:{form}}{unit}"
    return first, f"{spread.median:{form}}, {spread.p95:{form}}{unit}"


def _tracking(one: Tracking) -> str:
    """The counts of CLEAR MOT and the share of right numbers."""
    return (
        f"MOTA {_number(one.mota, '.3f', '')}, IDF1 {_number(one.idf1, '.3f', '')}, "
        f"mean distance {_number(100 * one.mean_m, '.1f', ' cm')}: "
        f"of {one.truths} places {one.missed} missed, {one.false} false, {one.switches} switches"
    )


def _slowest(times: Sequence[float]) -> str:
    return f"{max(times):.1f} s of {len(times)}" if times else "-"


def _percent(value: float) -> str:
    return _number(100 * value, ".1f", " %")


def _number(value: float, form: str, unit: str) -> str:
    return f"{value:{form}}{unit}" if math.isfinite(value) else "-"


def _plain(value: Any) -> Any:
    """JSON types, NaN as null."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, tuple):
        return [_plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
