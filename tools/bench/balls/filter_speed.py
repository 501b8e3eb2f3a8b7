"""Speed of the filters of targets side by side: `balls.kalman` and the models of `filters.kalman_filterpy`.

    python tools/bench/balls/filter_speed.py
    python tools/bench/balls/filter_speed.py --targets 1 30 --frames 200

All of them get the same positions, of targets that move at random and are hidden now and then. Rounds are
interleaved; of each filter the median of the rounds is shown, in ms of CPU time a frame, and its ratio to
`balls.kalman`.
"""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Sequence

import numpy as np

from followspot import Context, Room, Stage, Target, at
from followspot.message_checks.sealing import seal
from followspot.plugins.registry import load_stage
from followspot.tables.terminal import table
from followspot.tracking import Positions
from scripting import options_of

OWN = "balls.kalman"
FILTERPY = "filters.kalman_filterpy"
MODELS = ("constant_velocity", "constant_acceleration", "imm")
PERIOD = 1 / 30


def positions(targets: int, frames: int, seed: int = 0) -> list[Positions]:
    """Positions of targets that accelerate at random (6 m/s^2) and are hidden in every tenth frame."""
    rng = np.random.default_rng(seed)
    velocity = np.cumsum(rng.normal(0, 6 * PERIOD, (frames, targets, 3)), axis=0)
    place = np.cumsum(velocity * PERIOD, axis=0) + rng.normal(0, 0.005, (frames, targets, 3))
    made = []
    for number, xyz in enumerate(place):
        seen = np.flatnonzero((np.arange(targets) + number) % 10)
        count = len(seen)
        message = Positions(
            target=seen.astype(np.int32),
            xyz=xyz[seen],
            covariance=np.tile(np.eye(3) * 0.005**2, (count, 1, 1)),
            support=np.full(count, 9, np.int32),
            confirmed=np.ones(count, bool),
            evident=np.ones(count, bool),
            iterations=np.ones(count, np.int32),
            predicted=np.zeros(count, bool),
        )
        made.append(seal(at(round(number * PERIOD * 1e9), message)))
    return made


def filters(targets: int) -> dict[str, Stage]:
    """The filters by name, in a room of so many targets."""
    room = Room(targets={str(number): Target(str(number), 0.07) for number in range(targets)})
    made = {OWN: load_stage(OWN)(Context(room=room))}
    return made | {model: load_stage(FILTERPY)(Context(room=room), model=model) for model in MODELS}


def measure(targets: int, frames: int, rounds: int) -> dict[str, float]:
    """CPU time of each filter, ms a frame."""
    given = positions(targets, frames)
    spent: dict[str, list[float]] = {name: [] for name in filters(targets)}
    for _ in range(rounds):
        for name, stage in filters(targets).items():
            stage.setup()
            started = time.process_time()
            for message in given:
                stage.process(message)
            spent[name].append((time.process_time() - started) * 1e3 / frames)
    return {name: statistics.median(each) for name, each in spent.items()}


def _rows(result: dict[int, dict[str, float]]) -> Sequence[Sequence[str]]:
    return [
        (str(targets), name, f"{ms:.3f}", f"{ms / figures[OWN]:.1f}")
        for targets, figures in result.items()
        for name, ms in figures.items()
    ]


def main() -> None:
    """Measure and print a table."""
    parser = options_of(__doc__)
    parser.add_argument("--targets", type=int, nargs="+", default=[1, 3, 12], help="targets in the room")
    parser.add_argument("--frames", type=int, default=100, help="in a round")
    parser.add_argument("--rounds", type=int, default=5, help="interleaved")
    args = parser.parse_args()
    result = {targets: measure(targets, args.frames, args.rounds) for targets in args.targets}
    if args.json:
        print(json.dumps(result))
        return
    print(table(("targets", "filter", "ms a frame", "ratio"), _rows(result)))


if __name__ == "__main__":
    main()
