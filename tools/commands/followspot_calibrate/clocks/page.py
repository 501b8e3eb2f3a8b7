"""The page of `followspot calibrate clocks`."""

from __future__ import annotations

from followspot import Room
from followspot_calibrate.clocks.estimation import Offsets
from followspot_calibrate.report import Page, interval_chart, plain_table

HEAD = ("camera", "offset ms", "+- ms", "sightings")
NOTE = (
    "How much later than its time stamps say each camera takes its pictures; bars: two sigmas to each side."
)


def cells(room: Room, found: Offsets) -> list[tuple[str, ...]]:
    """One line per camera, as `HEAD` says."""
    return [
        (name, f"{1e3 * offset:+.2f}", f"{1e3 * sigma:.2f}", str(count))
        for name, offset, sigma, count in zip(
            room.cameras, found.offset, found.sigma, found.sightings, strict=True
        )
    ]


def page_of(room: Room, found: Offsets) -> Page:
    """The offsets, how well they are known, and from how much."""
    names, offset, sigma = list(room.cameras), 1e3 * found.offset, 1e3 * found.sigma
    summary = f"{len(names)} cameras, {offset.max() - offset.min():.1f} ms between the first and the last"
    return Page(
        f"Clocks of {room.name}",
        "good",
        summary,
        [],
        [
            plain_table("Clock offsets", HEAD, cells(room, found), note="Sightings are of moving targets."),
            interval_chart("Offsets", names, offset, sigma, "ms", NOTE),
        ],
    )
