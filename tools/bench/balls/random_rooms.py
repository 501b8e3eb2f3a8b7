"""How many targets a graph tracks badly in simulated rooms by chance, with each fusion.

    python tools/bench/balls/random_rooms.py --rooms 72 --first 1000 --frames 300 -o runs/rooms
    python tools/bench/balls/random_rooms.py --rooms 36 --first 107 --frames 1200 \
      --of graphs/rooms/simulated.yaml graphs/rooms/simulated6.yaml -o runs/performances

Each room has its own cameras, lenses, targets, people and light (`tools/benching/random_rooms.py`), and its
templates are learnt by the usual commands. A target is weak if less than 97 % of its trackable frames have a
position within 15 cm, if its RMSE exceeds 10 mm, if it ever has the identity of another, or if it is reported
while it is hidden. With `--of` the rooms are those, in other performances, one of each room for a seed, and
the bars are those that these rooms keep as they are: 99.5 %, an RMSE of 12 mm with mean shift and 7 mm with
the bundle, no other's identity, and at most 0.5 % of the hidden frames. Prints the weak targets with their
figures, then their number; scores.jsonl has all scores. The same command goes on if it was interrupted.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import followspot as fs
from benching.performed import performed
from benching.random_rooms import random_room
from followspot import room_file

ROOT = Path(__file__).parents[3]
FUSIONS = ("balls.mean_shift", "balls.bundle")
COMMAND = (sys.executable, "-m", "followspot.cli.main")

Score = dict[str, Any]


@dataclass(frozen=True)
class Bars:
    """What a target keeps that is not weak.

    coverage: least share of trackable frames; rmse_mm: most, by fusion; false: most share of hidden frames.
    """

    coverage: float
    rmse_mm: Mapping[str, float]
    false: float


BY_CHANCE = Bars(0.97, {"balls.mean_shift": 10.0, "balls.bundle": 10.0}, 0.0)
PERFORMED = Bars(0.995, {"balls.mean_shift": 12.0, "balls.bundle": 7.0}, 0.005)


def weaknesses(score: Mapping[str, Any], bars: Bars) -> list[str]:
    """Why a target counts as weak; nothing if it was never trackable and nothing false was reported."""
    found = []
    if score["coverage"] is not None and score["coverage"] < bars.coverage:
        found.append("coverage")
    if score["rmse_mm"] is not None and score["rmse_mm"] > bars.rmse_mm[score["fusion"]]:
        found.append("RMSE")
    if score["identity_switches"]:
        found.append("identity")
    if score["false_positions"] > bars.false * score["hidden_frames"]:
        found.append("false")
    return found


@dataclass(frozen=True)
class Case:
    """A room in a performance. of: the file of the room; None: a room by chance."""

    seed: int
    of: Path | None = None

    @property
    def name(self) -> str:
        """What tables call it."""
        return str(self.seed) if self.of is None else f"{self.of.stem} {self.seed}"

    def made(self, frames: int, folder: Path) -> Path:
        """Its room file, in a folder, with templates."""
        path = folder / "room.yaml"
        if self.of is not None:
            room_file.save(performed(room_file.load(self.of), self.seed, frames), path)
            return path
        room_file.save(random_room(self.seed, frames), path)
        templates_learnt(path)
        return path


def measured(case: Case, frames: int, graph: str, settings: Mapping[str, str]) -> list[Score]:
    """The scores of all targets of one room, with each fusion."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        room = case.made(frames, folder)
        return [
            {"room": case.name, "fusion": fusion, **score}
            for fusion in FUSIONS
            for score in _scores(graph, room, {"fuse.uses": fusion, **settings}, folder / fusion)
        ]


def templates_learnt(room: Path) -> None:
    """Add the templates of its targets to a simulated room, with clips beside it. Raises SystemExit."""
    clips = room.parent / "templates"
    _followspot("simulate", "--templates", "--room", room, "--out", clips)
    _followspot("calibrate", "targets", "--room", room, "--clips", clips, "--keep-cameras")


def _followspot(*words: Any) -> None:
    """Run a command. Raises SystemExit with what it said if it fails."""
    done = subprocess.run([*COMMAND, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"followspot {' '.join(map(str, words))}: {done.stdout}{done.stderr}")


def _scores(graph: str, room: Path, settings: Mapping[str, str], out: Path) -> Iterator[Score]:
    with fs.run(graph, room=room, set=settings, out=out) as run:
        table = run.wait().accuracy
    for row in table.rows:
        yield dict(zip(table.columns, row, strict=True))


def table(scores: Iterable[Score], bars: Bars) -> str:
    """A line for each weak target, then the numbers of weak targets and their reasons."""
    lines = [
        "| room | fusion | target | weak in | coverage | RMSE mm | p95 mm |",
        "|---|---|---|---|---|---|---|",
    ]
    weak, all_of, why = Counter[str](), Counter[str](), Counter[str]()
    for score in scores:
        all_of[score["fusion"]] += 1
        if found := weaknesses(score, bars):
            weak[score["fusion"]] += 1
            why.update(found)
            cells = (score["room"], score["fusion"], score["target"], ", ".join(found))
            figures = (score[key] for key in ("coverage", "rmse_mm", "p95_mm"))
            text = (*map(str, cells), *("-" if one is None else f"{one:.4g}" for one in figures))
            lines.append(f"| {' | '.join(text)} |")
    for fusion, number in all_of.items():
        lines.append(f"{fusion}: {weak[fusion]} of {number} targets are weak")
    lines.append(", ".join(f"{reason}: {number}" for reason, number in why.most_common()))
    return "\n".join(lines)


def main() -> None:
    """Measure the rooms that the file of scores lacks, then print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rooms", type=int, default=72, help="number of seeds (default: %(default)s)")
    parser.add_argument("--first", type=int, default=1000, help="first seed")
    parser.add_argument(
        "--of", type=Path, nargs="+", metavar="ROOM", help="simulated rooms in other performances"
    )
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    parser.add_argument("--set", action="append", default=[], metavar="STAGE.KEY=VALUE")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="rooms at a time")
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for scores.jsonl")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    file = args.out / "scores.jsonl"
    seeds = range(args.first, args.first + args.rooms)
    wanted = {case.name: case for case in (Case(seed, room) for seed in seeds for room in args.of or (None,))}
    known = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    missing = wanted.keys() - {score["room"] for score in known}
    settings = dict(text.split("=", 1) for text in args.set)
    with ProcessPoolExecutor(args.jobs) as pool, file.open("a") as lines:
        todo = [case for name, case in wanted.items() if name in missing]
        work = [pool.submit(measured, case, args.frames, args.graph, settings) for case in todo]
        for number, one in enumerate(work, 1):
            found = one.result()
            lines.writelines(json.dumps(score) + "\n" for score in found)
            lines.flush()
            known += found
            print(f"\r{number}/{len(work)} rooms", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    print(table((score for score in known if score["room"] in wanted), PERFORMED if args.of else BY_CHANCE))


if __name__ == "__main__":
    main()
