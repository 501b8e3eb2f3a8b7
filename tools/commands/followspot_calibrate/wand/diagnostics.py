"""Warnings after a successful calibration: which camera, why, and what to do."""

from __future__ import annotations

from collections.abc import Collection

from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.diagnosis import DEEP, shallow
from followspot_calibrate.wand.hazards.bulbs import length_warnings
from followspot_calibrate.wand.hazards.moved import Moved, moved_cameras
from followspot_calibrate.wand.hazards.planar import FLAT, REMEDY, flatness
from followspot_calibrate.wand.hazards.unlinked import other_size
from followspot_calibrate.wand.pairs import FEWEST
from followspot_calibrate.wand.rounds import RobustAdjustment
from followspot_calibrate.wand.solving import Solved
from followspot_calibrate.wand.timing import Timed

MANY = 0.2
"""Share of a camera's sightings that fit nothing from which on something is wrong with it."""


def warnings_of(solved: Solved, unit: float | None = None, fps: float | None = None) -> list[str]:
    """Sentences for the user. unit: m per unit of the solution, if known; fps: frames a second, if known."""
    adjusted, moved = solved.adjusted, moved_cameras(solved.adjusted, solved.sightings)
    warnings = late_warnings(solved.timed, fps) + [moved_warning(adjusted, one, unit) for one in moved]
    warnings += sparse_warnings(solved.sightings, adjusted, {one.number for one in moved})
    if solved.intrinsics == "free":
        warnings += depth_warnings(adjusted)
    else:
        warnings += size_warnings(solved.sightings)
    if solved.planar:
        warnings.append(f"the points lie nearly in a plane, heights above it are less certain: {REMEDY}")
    if solved.rods is not None:
        warnings += length_warnings(adjusted, solved.rods, solved.sightings.pixel)
    return warnings


def size_warnings(sightings: Sightings) -> list[str]:
    """Cameras whose points look like those of a smaller recording, which may have got a place by chance."""
    found = (other_size(sightings, number) for number in range(len(sightings.cameras)))
    return [text for text in found if text]


def late_warnings(timed: Timed, fps: float | None) -> list[str]:
    """Cameras that are not synchronised."""
    warnings = []
    for name, late, drift in zip(timed.sightings.cameras, timed.late, timed.drift, strict=True):
        if drift:
            warnings.append(
                f"{name} comes {abs(drift):.1f} frames {'later' if drift > 0 else 'earlier'} in the second "
                "half of the recording than in the first: it lost frames, or its rate is another; "
                "record again"
            )
        elif late:
            warnings.append(
                f"{name} is {_frames(abs(late), fps)} {'late' if late > 0 else 'early'}; that was corrected "
                "here: synchronise the cameras, or note it in the room file (--fps FPS --clock-offsets)"
            )
    return warnings


def moved_warning(adjusted: RobustAdjustment, moved: Moved, unit: float | None) -> str:
    """When a camera was moved, how far, and which of its poses was found."""
    far = "" if unit is None else f"{1000 * unit * moved.shift:.0f} mm and "
    turn = f"{57.29578 * moved.turn:.1f} degrees"
    name = adjusted.cameras[moved.number].name
    return (
        f"{name} was moved at frame {moved.frame}, by {far}{turn}: its pose is "
        f"the one {'before' if moved.kept_before else 'after'}; calibrate with what was recorded since: "
        f"--frames {moved.frame}-"
    )


def sparse_warnings(
    sightings: Sightings, adjusted: RobustAdjustment, explained: Collection[int]
) -> list[str]:
    """Cameras that rest on few of their points; explained: numbers of cameras of which the cause is known."""
    warnings, strange = [], []
    for number, camera in enumerate(adjusted.cameras):
        total, used = int(sightings.seen[:, number].sum()), int(adjusted.used[:, number].sum())
        if used < FEWEST:
            warnings.append(f"{camera.name} rests on {used} points, {FEWEST} needed: wave in its view")
        elif used < (1 - MANY) * total and number not in explained:
            strange.append(f"{100 * (1 - used / total):.0f} % of the points of {camera.name}")
    if strange:
        warnings.append(
            f"{', '.join(strange)} fit no other camera: look for reflections and second lights in its view"
        )
    return warnings


def depth_warnings(adjusted: RobustAdjustment) -> list[str]:
    """Warnings about estimated intrinsics that the points leave open."""
    warnings, flat = [], shallow(adjusted)
    if flat:
        ratios = ", ".join(f"{name} {ratio:.1f}" for name, ratio in flat.items())
        warnings.append(
            f"the depth of the points, farthest over nearest, is under {DEEP:g} ({ratios}): the focal length "
            "is not well determined; wave nearer to the camera and farther off, or calibrate its intrinsics"
        )
    if flatness(adjusted.points) < FLAT:
        warnings.append(f"the points lie nearly in a plane, which leaves unknown lenses open: {REMEDY}")
    return warnings


def _frames(late: float, fps: float | None) -> str:
    return f"{late:.2f} frames" + ("" if fps is None else f" ({1000 * late / fps:.1f} ms)")
