"""Whether the tracker holds on copies of recordings: reversed in time, with noise, encoded in other ways.

    python tools/bench/balls/copies.py recordings/dev5.yaml recordings/dev6.yaml
    python tools/bench/balls/copies.py recordings/dev5.yaml --codecs FFV1 --noise 2 --targets blue --json

Each room is tracked as recorded, and each of its copies, with each fusion. For each target: the share of its
trackable frames that have a position within 15 cm of the truth, the share that are reported beyond it, the
RMSE, the share of errors within the ellipsoid of 95 % that the sigmas span, and the mean of the squared
errors over their variances (NEES over 3: 1 if sigmas are right, more if they are too small). The last lines
have the mean over all copies and the worst of them, beside the aims: at least 97 % within, at most 0.5 %
beyond. Copies differ as little as two recordings of one performance would, so what
holds on the recording alone holds by chance.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import numpy as np

from bench.balls.motion_models import truths
from bench.balls.situations import FUSIONS, GRAPH, rmse_mm, tracked
from benching.room_copy import Copy, copied
from followspot import room_file
from followspot.messages import Array
from followspot.tables.terminal import table
from followspot_accuracy import TrackTable, TruthTable, truth_of
from followspot_accuracy.targets.metrics import within_ellipsoid
from followspot_accuracy.targets.scoring import REACH, trajectory
from scripting import options_of

LEAST_WITHIN, MOST_BEYOND = 0.97, 0.005
"""The aims, shares of a target's trackable frames."""
RECORDED = "as recorded"


@dataclass(frozen=True)
class Held:
    """How a target of one copy is tracked with one fusion."""

    fusion: str
    room: str
    copy: str
    target: str
    frames: int
    within: float
    beyond: float
    rmse_mm: float | None
    within_95: float | None
    nees: float | None


def main() -> None:
    """Measure and print tables."""
    parser = options_of(__doc__)
    parser.add_argument("rooms", type=Path, nargs="+", help="recorded, with ground truth")
    parser.add_argument("--graph", type=Path, default=GRAPH, help="(default: the demo's)")
    parser.add_argument("--noise", type=float, nargs="+", default=[1.0, 2.0], help="sigmas, grey levels")
    parser.add_argument("--codecs", nargs="+", default=["FFV1", "MJPG", "mp4v"], help="four letters each")
    parser.add_argument("--fusions", nargs="+", default=list(FUSIONS))
    parser.add_argument("--targets", nargs="+", help="(default: all)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="STAGE.KEY=VALUE", help="of the tracker"
    )
    args = parser.parse_args()
    settings = dict(one.split("=", 1) for one in args.set)
    copies = [Copy(*how) for how in product((False, True), args.noise, args.codecs)]
    found = []
    for path in args.rooms:
        for one in measured(path, copies, args.graph, settings, args.fusions):
            if not args.targets or one.target in args.targets:
                found.append(one)
                print("\t".join(cells(one)), file=sys.stderr, flush=True)
    if args.json:
        print(json.dumps([asdict(one) for one in found]))
        return
    heads = ["fusion", "room", "copy", "target", "frames", "within 15 cm", "beyond", "RMSE mm"]
    heads += ["ellipsoid", "NEES/3"]
    print(table(heads, [cells(one) for one in found]))
    print(f"\nCopies; the aims are {LEAST_WITHIN:.0%} within and {MOST_BEYOND:.1%} beyond.")
    heads = ["fusion", "room", "target", "within: mean", "worst", "", "beyond: mean", "worst"]
    heads += ["ellipsoid", "NEES/3"]
    print(table(heads, list(summary(found))))


def cells(one: Held) -> list[str]:
    """The figures as text, in the order of the heads."""
    shares = shown(one.within, ".1%"), shown(one.beyond, ".1%"), shown(one.rmse_mm, ".1f")
    stated = shown(one.within_95, ".1%"), shown(one.nees, ".2f")
    return [one.fusion, one.room, one.copy, one.target, str(one.frames), *shares, *stated]


def summary(found: Sequence[Held]) -> Iterator[list[str]]:
    """A line for each target and fusion: the mean and the worst of its copies."""
    copies = [one for one in found if one.copy != RECORDED]
    for key in dict.fromkeys((one.fusion, one.room, one.target) for one in copies):
        mine = [one for one in copies if (one.fusion, one.room, one.target) == key]
        within, beyond = np.array([[one.within, one.beyond] for one in mine]).T
        worst = mine[int(within.argmin())].copy
        shares = within.mean(), within.min(), beyond.mean(), beyond.max()
        first, last, *others = (shown(share, ".1%") for share in shares)
        stated = (mean(one.within_95 for one in mine), ".1%"), (mean(one.nees for one in mine), ".2f")
        yield [*key, first, last, worst, *others, *(shown(*figure) for figure in stated)]


def shown(figure: float | None, form: str) -> str:
    """A figure as text."""
    return "-" if figure is None else f"{figure:{form}}"


def mean(figures: Iterable[float | None]) -> float | None:
    """The mean of those that are known."""
    known = [one for one in figures if one is not None]
    return float(np.mean(known)) if known else None


def measured(
    path: Path, copies: Iterable[Copy], graph: Path, settings: Mapping[str, str], fusions: Sequence[str]
) -> Iterator[Held]:
    """How the targets of a room are tracked, as it was recorded and in its copies."""
    yield from scored(path, path.stem, RECORDED, graph, settings, fusions)
    for how in copies:
        with tempfile.TemporaryDirectory() as folder:
            copy = copied(path, Path(folder), how)
            yield from scored(copy, path.stem, how.name, graph, settings, fusions)


def scored(
    room: Path, name: str, copy: str, graph: Path, settings: Mapping[str, str], fusions: Sequence[str]
) -> Iterator[Held]:
    """How the targets of one recording are tracked with each fusion."""
    for fusion in fusions:
        tracks, count = tracked(graph, room, None, {"fuse.uses": fusion, **settings})
        truth = truth_of(truths(room_file.load(room), count))
        yield from held(tracks, truth, (fusion, name, copy))


def held(tracks: TrackTable, truth: TruthTable, of: tuple[str, str, str]) -> Iterator[Held]:
    """The figures of each target that is trackable. of: fusion, room and copy."""
    for own, name in enumerate(truth.objects):
        there = truth.trackable[:, own]
        if not there.any():
            continue
        track = trajectory(tracks, name, truth.time)
        off, sigma = (track.xyz - truth.xyz[:, own])[there], track.sigma[there]
        error = np.linalg.norm(off, axis=1)
        within, beyond = (error < REACH).mean(), (error >= REACH).mean()
        yield Held(
            *of, name, len(error), float(within), float(beyond), rmse_mm(error), *consistency(off, sigma)
        )


def consistency(off: Array, sigma: Array) -> tuple[float | None, float | None]:
    """Share of errors within the ellipsoid of 95 %, and NEES over 3: (N, 3) m each, NaN if unknown."""
    known = np.isfinite(off).all(axis=1) & np.isfinite(sigma).all(axis=1)
    if not known.any():
        return None, None
    off, sigma = off[known], sigma[known]
    return float(within_ellipsoid(off, sigma).mean()), float(np.square(off / sigma).mean())


if __name__ == "__main__":
    main()
