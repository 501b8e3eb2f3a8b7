"""Coverage and error of a graph in parts of a simulated room: which mix of cameras is worth what.

    python tools/bench/balls/camera_mixes.py --seeds 101 102 103 104 --frames 600

Each mix is a part of the room's cameras, in the order of the room. The targets of rooms without colour
cameras are told once: by marks at their true positions in the first frame. Prints a Markdown table: means
over seeds and targets, the worst target of any seed, and what was false.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

import followspot as fs
from benching.performed import performed
from followspot import room_file
from followspot.context import Context
from followspot.room import Room, Target
from followspot_sim.truth import SimTruth

ROOT = Path(__file__).parents[3]


class Mix(NamedTuple):
    """So many colour, infrared and depth cameras, and the number of targets; 0: all of the room."""

    color: int
    infrared: int
    targets: int = 0
    depth: int = 0

    def __str__(self) -> str:
        counts = (self.color, "colour"), (self.infrared, "infrared"), (self.depth, "depth")
        kinds = [f"{n} {kind}" for n, kind in counts if n]
        return " + ".join(kinds) + (", one target" if self.targets == 1 else "")


SEEDS = (101, 102, 103, 104)
MIXES = (
    Mix(3, 3),
    Mix(2, 1),
    Mix(1, 2),
    Mix(1, 1),
    Mix(3, 0),
    Mix(2, 0),
    Mix(0, 3),
    Mix(0, 2),
    Mix(0, 3, 1),
    Mix(0, 2, 1),
)


def part(room: Room, mix: Mix, seed: int, frames: int) -> Room:
    """The cameras and targets of a mix, in another performance."""
    counts = {"color": mix.color, "infrared": mix.infrared, "depth": mix.depth}
    names = [
        name
        for kind, count in counts.items()
        for name in [n for n, c in room.cameras.items() if c.kind == kind][:count]
    ]
    targets = list(room.targets)[: mix.targets or None]
    return performed(
        replace(
            room,
            cameras={name: room.cameras[name] for name in names},
            targets={name: _seen_by(room.targets[name], names) for name in targets},
        ),
        seed,
        frames,
    )


def _seen_by(target: Target, cameras: Sequence[str]) -> Target:
    """The target with the templates of these cameras."""
    parts: Any = {
        name: {camera: one for camera, one in getattr(target, name).items() if camera in cameras}
        for name in ("hue_histogram", "area", "gray")
    }
    return replace(target, **parts)


def first_positions(room: Room) -> dict[str, list[float]]:
    """True position of each target in the first frame, m."""
    assert room.truth is not None
    source = SimTruth(Context(room=room), **room.truth.params)
    source.setup()
    truth = source.truth(0)
    return dict(zip(truth.objects, np.round(truth.xyz, 2).tolist(), strict=True))


def scores(graph: str, room: Room, settings: Mapping[str, Any], folder: Path) -> list[dict[str, Any]]:
    """The score of each target."""
    room_file.save(room, folder / "room.yaml")
    with fs.run(graph, room=folder / "room.yaml", set=settings, out=folder / "out") as run:
        report = run.wait()
    names = report.accuracy.columns
    return [dict(zip(names, row, strict=True)) for row in report.accuracy.rows]


def row(mix: Mix, found: Sequence[Mapping[str, Any]]) -> str:
    """A line of the table."""
    measured = [one for one in found if one["rmse_mm"] is not None]
    frames, coverage = (np.array([one[key] for one in found], float) for key in ("frames", "coverage"))
    weight, rmse, median = (
        np.array([one[key] for one in measured]) for key in ("frames", "rmse_mm", "median_mm")
    )
    cells = (
        str(mix),
        f"{frames.sum():.0f}",
        f"{100 * np.nanmean(coverage):.1f} %",
        f"{100 * np.nanmin(coverage):.1f} %",
        f"{math.sqrt(np.square(rmse) @ weight / weight.sum()):.1f} mm" if measured else "-",
        f"{median.mean():.1f} mm" if measured else "-",
        str(sum(one["identity_switches"] for one in found)),
        f"{sum(one['false_positions'] for one in found)} of {sum(one['hidden_frames'] for one in found)}",
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Run every mix with every seed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    parser.add_argument("--room", type=Path, default=ROOT / "graphs/rooms/simulated.yaml")
    parser.add_argument("--seeds", type=int, nargs="+", action="extend", help="default: 101 to 104")
    parser.add_argument("--frames", type=int, default=600)
    parser.add_argument("--set", action="append", default=[], metavar="STAGE.KEY=VALUE")
    mixes = "only these: 3+3, 0+3:1 (one target), 0+0+2 (depth)"
    parser.add_argument("--mix", nargs="+", action="extend", help=mixes)
    args = parser.parse_args()
    room = room_file.load(args.room)
    settings = dict(text.split("=", 1) for text in args.set)
    print("| cameras | frames | coverage | worst | RMSE | median | switches | false when hidden |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for mix in MIXES if args.mix is None else map(parsed, args.mix):
        found: list[dict[str, Any]] = []
        for seed in args.seeds or SEEDS:
            here = part(room, mix, seed, args.frames)
            told = {} if mix.color else {"track.marks": first_positions(here)}
            with TemporaryDirectory() as folder:
                found += scores(args.graph, here, {**settings, **told}, Path(folder))
        print(row(mix, found), flush=True)


def parsed(text: str) -> Mix:
    """A mix as it is written: 2+1, 0+3:1 for one target, or 1+1+2 with two depth cameras."""
    cameras, _, targets = text.partition(":")
    color, infrared, *depth = map(int, cameras.split("+"))
    return Mix(color, infrared, int(targets or 0), *depth)


if __name__ == "__main__":
    main()
