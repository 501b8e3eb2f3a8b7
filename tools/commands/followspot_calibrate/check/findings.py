"""The findings of a check, and its verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot_calibrate.check.against import Comparison
from followspot_calibrate.check.agreement import Agreement
from followspot_calibrate.check.drift import Change
from followspot_calibrate.check.lengths import MeasuredLength
from followspot_calibrate.report import Course

GROSS_SHARE = 0.2
"""Share of gross errors among a camera's sightings that is worth a warning."""


@dataclass(frozen=True, eq=False)
class Drift:
    """One camera over time; change: None if it stayed."""

    course: Course
    change: Change | None


@dataclass(frozen=True, eq=False)
class Findings:
    """Everything that was measured; None if there was no evidence for it.

    limit: px, as the user gave it; differences from another calibration count only then.
    """

    cameras: Sequence[Camera]
    points: Agreement | None = None
    tracks: Agreement | None = None
    drifts: Sequence[Drift] = ()
    length: MeasuredLength | None = None
    comparison: Comparison | None = None
    limit: float | None = None

    @property
    def failures(self) -> list[str]:
        """Figures beyond their limits, each with the camera and the remedy."""
        found = [] if self.points is None else at_fault(self.points, "sightings", {})
        found += [] if self.tracks is None else at_fault(self.tracks, "blobs", self.moved)
        if self.length is not None and not self.length.good:
            found.append(
                f"the known length of {self.length.true_m:g} m measures {self.length.mean_mm / 1000:.4g} m: "
                f"the scale is off by {100 * (self.length.ratio - 1):+.1f} %; "
                f"calibrate wand again with --length {self.length.true_m:g}"
            )
        return found + self.differences

    @property
    def differences(self) -> list[str]:
        """Cameras that another calibration places elsewhere; none if the user gave no limit."""
        if self.comparison is None or self.limit is None:
            return []
        return [
            f"{one.name}: its picture differs by {one.judged_px:.2f} px from the other calibration "
            f"(limit {self.limit:.2f} px)"
            for one in self.comparison.cameras
            if one.judged_px > self.limit
        ]

    @property
    def warnings(self) -> list[str]:
        """Warnings and notes."""
        found = [] if self.comparison is None else list(self.comparison.notes)
        for agreement in (self.points, self.tracks):
            found += [] if agreement is None else coverage_warnings(agreement)
        return found + [moved_text(drift) for drift in self.drifts if drift.change is not None]

    @property
    def moved(self) -> dict[str, float]:
        """Cameras that moved from one moment to the next, and when, s."""
        return {
            one.course.camera: one.change.at
            for one in self.drifts
            if one.change is not None and one.change.at is not None
        }

    @property
    def blamed(self) -> list[str]:
        """Names of the cameras that are beyond their limit."""
        numbers = {n for one in (self.points, self.tracks) if one is not None for n in one.suspects}
        named = {self.cameras[n].name for n in numbers}
        if self.comparison is not None and self.limit is not None:
            named |= {one.name for one in self.comparison.cameras if one.judged_px > self.limit}
        return [camera.name for camera in self.cameras if camera.name in named]

    @property
    def verdict(self) -> str:
        """The verdict in one line: "good: ...", or the problem."""
        if self.blamed:
            names = ", ".join(self.blamed)
            return f"look at {names}: {self.failures[0].removeprefix(self.blamed[0] + ': ')}"
        if self.failures:
            return f"not good: {self.failures[0]}"
        measured = [one for one in (self.points, self.tracks) if one is not None]
        said = [summary(one) for one in measured]
        if self.length is not None:
            said.append(f"the known length is right within {abs(1000 * (self.length.ratio - 1)):.1f} mm/m")
        if self.comparison is not None:
            mean = np.mean([one.judged_px for one in self.comparison.cameras])
            said.append(f"differs from the other calibration by {mean:.2f} px on average")
        return ("good: " if measured or self.length else "compared: ") + ", ".join(said)


def at_fault(agreement: Agreement, noun: str, moved: Mapping[str, float]) -> list[str]:
    """Sentences about the cameras beyond the limit; moved: camera -> when, s."""
    warnings = []
    for n in agreement.suspects:
        name = agreement.cameras[n].name
        cause = f"it moved at {moved[name]:.1f} s" if name in moved else "it moved or is badly calibrated"
        warnings.append(
            f"{name}: its {noun} {_distance(agreement, n)}; {cause}: calibrate wand again for {name}"
        )
    if agreement.at_odds:
        judged = np.flatnonzero(np.isfinite(agreement.score)).tolist()
        rest = [n for n in judged if n not in agreement.suspects]
        values = ", ".join(f"{agreement.cameras[n].name} {agreement.score[n]:.1f} px" for n in rest)
        warnings.append(
            f"the cameras do not agree with each other ({values}); calibrate wand again for all of them"
        )
    if not np.isfinite(agreement.score).any():
        warnings.append(
            "no camera shares enough points with two others to be checked; show points to more cameras"
        )
    return warnings


def _distance(agreement: Agreement, number: int) -> str:
    """How far the sightings of a suspect are from where they should be.

    Too few may be left to tell, if the cameras that are trusted agree about few points.
    """
    if not np.isfinite(agreement.score[number]):
        return "fit no points that the other cameras agree about"
    return (
        f"are {agreement.score[number]:.1f} px from where the other cameras expect them "
        f"(limit {agreement.limit[number]:.2f} px)"
    )


def coverage_warnings(agreement: Agreement) -> list[str]:
    """Warnings about cameras that saw too little, or much that is something else."""
    found = []
    for number, camera in enumerate(agreement.cameras):
        known = np.isfinite(agreement.length[:, number])
        if not np.isfinite(agreement.score[number]):
            found.append(
                f"{camera.name} shares {known.sum()} points with two other cameras, too few to be checked; "
                "is it covered, or did it move far?"
            )
        elif number not in agreement.suspects and agreement.gross[known, number].mean() > GROSS_SHARE:
            share = 100 * agreement.gross[known, number].mean()
            found.append(f"{share:.0f} % of what {camera.name} saw is something else; look for reflections")
    return found


def moved_text(drift: Drift) -> str:
    """A camera that moved, in a sentence."""
    assert drift.change is not None
    size, camera = drift.change.size, drift.course.camera
    if drift.change.at is None:
        return f"{camera} drifts: {size:.1f} px over the recording; is it fixed firmly, is it warm?"
    return f"{camera} moved by {size:.1f} px at {drift.change.at:.1f} s"


def summary(agreement: Agreement) -> str:
    """The agreement of the cameras in a few words."""
    judged = np.isfinite(agreement.score)
    middle = np.nanmedian(agreement.length[:, judged], axis=0)
    return (
        f"{judged.sum()} cameras agree, median error {middle.min():.2f} to {middle.max():.2f} px "
        f"(limit {agreement.limit[judged].min():.2f} px)"
    )
