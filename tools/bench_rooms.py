"""How many targets a graph tracks badly in simulated rooms by chance, with each fusion.

    python tools/bench_rooms.py --rooms 72 --first 1000 --frames 300 -o runs/rooms

Each room has its own cameras, lenses, targets, people and light (`tools/benching/random_rooms.py`), and its
templates are learnt by the usual commands. A target is weak if less than 97 % of its trackable frames have a
position within 15 cm, if its RMSE exceeds 10 mm, if it ever has the identity of another, or if it is reported
while it is hidden. Prints the weak targets with their figures, then their number; scores.jsonl has all
scores. The same command goes on if it was interrupted.
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
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import followspot as fs
from benching.random_rooms import random_room
from followspot import room_file

ROOT = Path(__file__).parent.parent
FUSIONS = ("balls.mean_shift", "balls.bundle")
MINIMUM_COVERAGE = 0.97
MAXIMUM_RMSE_MM = 10.0
COMMAND = (sys.executable, "-m", "followspot.cli.main")

Score = dict[str, Any]


def weaknesses(score: Mapping[str, Any]) -> list[str]:
    """Why a target counts as weak; nothing if it was never trackable and nothing false was reported."""
    found = []
    if score["coverage"] is not None and score["coverage"] < MINIMUM_COVERAGE:
        found.append("coverage")
    if score["rmse_mm"] is not None and score["rmse_mm"] > MAXIMUM_RMSE_MM:
        found.append("RMSE")
    if score["identity_switches"]:
        found.append("identity")
    if score["false_positions"]:
        found.append("false")
    return found


def measured(seed: int, frames: int, graph: str, settings: Mapping[str, str]) -> list[Score]:
    """The scores of all targets of one room, with each fusion."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        room = folder / "room.yaml"
        room_file.save(random_room(seed, frames), room)
        _followspot("simulate", "--templates", "--room", room, "--out", folder / "templates")
        _followspot("calibrate", "targets", "--room", room, "--clips", folder / "templates", "--keep-cameras")
        return [
            {"room": seed, "fusion": fusion, **score}
            for fusion in FUSIONS
            for score in _scores(graph, room, {"fuse.uses": fusion, **settings}, folder / fusion)
        ]


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


def table(scores: Iterable[Score]) -> str:
    """A line for each weak target, then the numbers of weak targets and their reasons."""
    lines = [
        "| room | fusion | target | weak in | coverage | RMSE mm | p95 mm |",
        "|---|---|---|---|---|---|---|",
    ]
    weak, all_of, why = Counter[str](), Counter[str](), Counter[str]()
    for score in scores:
        all_of[score["fusion"]] += 1
        if found := weaknesses(score):
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
    parser.add_argument("--rooms", type=int, default=72, help="number of rooms (default: %(default)s)")
    parser.add_argument("--first", type=int, default=1000, help="seed of the first room")
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    parser.add_argument("--set", action="append", default=[], metavar="STAGE.KEY=VALUE")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="rooms at a time")
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for scores.jsonl")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    file = args.out / "scores.jsonl"
    wanted = range(args.first, args.first + args.rooms)
    known = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    missing = [seed for seed in wanted if seed not in {score["room"] for score in known}]
    settings = dict(text.split("=", 1) for text in args.set)
    with ProcessPoolExecutor(args.jobs) as pool, file.open("a") as lines:
        work = [pool.submit(measured, seed, args.frames, args.graph, settings) for seed in missing]
        for number, one in enumerate(work, 1):
            found = one.result()
            lines.writelines(json.dumps(score) + "\n" for score in found)
            lines.flush()
            known += found
            print(f"\r{number}/{len(work)} rooms", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    print(table(score for score in known if score["room"] in wanted))


if __name__ == "__main__":
    main()
