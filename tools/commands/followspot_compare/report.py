"""The comparison as text and as JSON types."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from followspot.tables.terminal import table
from followspot_accuracy import PersonsScore, persons_to_json, to_json
from followspot_compare.columns import COLUMNS, Figures, finite, measured
from followspot_compare.persons import persons_means, persons_text
from followspot_compare.trial import Trial


@dataclass(frozen=True)
class Comparison:
    """All trials, variant by variant; the first variant is what the others are held against."""

    trials: tuple[Trial, ...]
    unchanged: tuple[str, ...] = ()
    """Variants whose files are those of the first one, byte for byte."""

    @property
    def variants(self) -> tuple[str, ...]:
        """In the order in which they were given."""
        return tuple(dict.fromkeys(trial.variant for trial in self.trials))

    @property
    def rooms(self) -> tuple[str, ...]:
        """In the order in which they were given."""
        return tuple(dict.fromkeys(trial.room for trial in self.trials))

    @property
    def targets(self) -> tuple[tuple[str, str], ...]:
        """Room and name of everything that was there or was reported."""
        return tuple(dict.fromkeys((t.room, name) for t in self.trials for name in t.targets))

    @property
    def trackable(self) -> tuple[tuple[str, str], ...]:
        """Room and name of everything that was there and could be seen."""
        return tuple(
            dict.fromkeys(
                (t.room, name) for t in self.trials for name, f in t.targets.items() if f.tracks.frames
            )
        )

    def of_target(self, room: str, name: str) -> dict[str, Figures]:
        """One target's figures for each variant; none if it was neither there nor reported."""
        return {
            t.variant: [t.targets[name]] if name in t.targets else [] for t in self.trials if t.room == room
        }

    def of_all(self, room: str | None = None) -> dict[str, Figures]:
        """All targets' figures for each variant, in one room or in all."""
        return {
            variant: [
                figures
                for t in self.trials
                if t.variant == variant and room in (None, t.room)
                for figures in t.targets.values()
            ]
            for variant in self.variants
        }

    def persons(self) -> dict[str, dict[str, PersonsScore]]:
        """Scores of persons' poses for each variant and room that has them."""
        return {
            variant: {t.room: t.persons for t in self.trials_of(variant) if t.persons is not None}
            for variant in self.variants
        }

    def trials_of(self, variant: str) -> tuple[Trial, ...]:
        """One variant in every room."""
        return tuple(trial for trial in self.trials if trial.variant == variant)

    def iterations(self, variant: str) -> tuple[int, ...]:
        """Number of positions that took 0, 1, 2, ... iterations, over all rooms."""
        counts = [trial.iterations for trial in self.trials_of(variant)]
        longest = max(map(len, counts))
        return tuple(sum(c[i] if i < len(c) else 0 for c in counts) for i in range(longest))

    def ratio(self, variant: str, key: str) -> float:
        """Mean over all targets divided by that of the first variant; NaN if either is not known."""
        of = next(column.of for column in COLUMNS if column.key == key)
        groups = self.of_all()
        first = of(groups[self.variants[0]])
        return of(groups[variant]) / first if first else math.nan


def text(comparison: Comparison) -> str:
    """Tables: accuracy of targets or persons, speed, and iterations if they are known."""
    persons = comparison.persons()
    parts = [_accuracy(comparison)] if comparison.targets else []
    parts += [persons_text(persons)] if any(persons.values()) else []
    parts.append(_speed(comparison))
    if any(comparison.iterations(variant) for variant in comparison.variants):
        parts.append(_iterations(comparison))
    first = comparison.variants[0]
    same = [f"{name} changes nothing: its files are those of {first}" for name in comparison.unchanged]
    parts += ["\n".join(same)] if same else []
    return "\n\n".join(parts)


def data(comparison: Comparison) -> dict[str, Any]:
    """Every trial, and means and ratios over all targets; NaN becomes null."""
    groups = comparison.of_all()
    return {
        "variants": list(comparison.variants),
        "rooms": list(comparison.rooms),
        "trials": [_trial_data(trial) for trial in comparison.trials],
        "means": {v: {c.key: finite(c.of(groups[v])) for c in COLUMNS} for v in comparison.variants},
        "ratios": {
            v: {c.key: finite(comparison.ratio(v, c.key)) for c in COLUMNS if c.ratio}
            for v in comparison.variants
        },
        "persons": persons_means(comparison.persons()),
        "unchanged": list(comparison.unchanged),
    }


def _trial_data(trial: Trial) -> dict[str, Any]:
    scores = to_json({name: figures.tracks for name, figures in trial.targets.items()})
    more = ("true_jerk_cost", "fused_mm", "fused_px", "detection_px", "detection_std_px")
    for name, figures in trial.targets.items():
        scores[name] |= {key: finite(getattr(figures, key)) for key in more}
        scores[name] |= {f"recoveries_{key}": value for key, value in figures.recovery._asdict().items()}
        scores[name] |= {"pairs": [finite(value) for value in figures.pairs]}
    return {
        "variant": trial.variant,
        "room": trial.room,
        "frames": trial.frames,
        "seconds": round(trial.seconds, 6),
        "tracking_ms": round(trial.tracking_ms, 6),
        "targets": scores,
        "persons": persons_to_json(trial.persons) if trial.persons else {},
        "iterations": list(trial.iterations),
    }


def _accuracy(comparison: Comparison) -> str:
    """A group of rows per target, per room and for all; then the ratios."""
    columns = measured(comparison.of_all())
    rows: list[tuple[str, ...]] = []
    for title, group in _groups(comparison):
        rows.append((title, *[""] * len(columns)))
        rows += [(f"  {name}", *(c.cell(group[name]) for c in columns)) for name in comparison.variants]
    if len(comparison.variants) > 1:
        rows.append((f"ratio to {comparison.variants[0]}", *[""] * len(columns)))
    for name in comparison.variants[1:]:
        ratios = [comparison.ratio(name, c.key) if c.ratio else math.nan for c in columns]
        rows.append((f"  {name}", *(f"{r:.2f}" if math.isfinite(r) else "" for r in ratios)))
    return "accuracy against ground truth\n" + table(("", *(c.heading for c in columns)), rows)


def _groups(comparison: Comparison) -> Iterator[tuple[str, dict[str, Figures]]]:
    several = len(comparison.rooms) > 1
    for room, name in comparison.targets:
        yield f"{room}, {name}" if several else name, comparison.of_target(room, name)
    if several:
        for room in comparison.rooms:
            yield f"{room}, all targets", comparison.of_all(room)
    yield "all targets", comparison.of_all()


def _speed(comparison: Comparison) -> str:
    """Whole runs, and the tracking stages alone."""
    rows = []
    for name in comparison.variants:
        trials = comparison.trials_of(name)
        frames = sum(t.frames for t in trials)
        tracking = sum(t.tracking_ms * t.frames for t in trials) / max(1, frames)
        rows.append(
            (name, str(frames), f"{frames / sum(t.seconds for t in trials):.0f}", f"{tracking:.2f} ms")
        )
    return "speed\n" + table(("", "frames", "frames/s", "tracking per frame"), rows)


def _iterations(comparison: Comparison) -> str:
    counts = {name: comparison.iterations(name) for name in comparison.variants}
    longest = max(map(len, counts.values()))
    rows = [(name, *(str(n) for n in c), *["0"] * (longest - len(c))) for name, c in counts.items() if c]
    return "steps of the fusion: positions that took so many\n" + table(
        ("", *(str(step) for step in range(longest))), rows
    )
