"""Paths carried through gaps by real inertial sensors: `imu.orientation` and `balls.inertial` on BROAD.

    python tools/bench/balls/inertial.py FOLDER --seeds 3

The folder holds one .npz per trial (its README tells the arrays): readings at 286 Hz and the optical path.
The path becomes positions of --rate with 3 mm of noise, hidden for 1 s in every 3 s. For each trial: median
and 95th percentile of the error 0.1, 0.25, 0.5 and 1.0 s after the last position, in mm, after 15 s of
motion; how many of the hidden positions lie within 1.96 sigma along each axis and how many are given at all,
in %; and the orientation RMSE in degrees, total, heading and inclination. Below each line, the figures of a
fit of the last nine positions, carried on by VQF and doubly integrated accelerations, from the README.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benching.inertial_trial import Trial, read, truth_at
from followspot import Array, Context, Member, Room, Sensor, Stage, Target, at
from followspot.inertial import Inertial, PosedTracks
from followspot.message_checks.sealing import seal
from followspot.plugins.registry import load_stage
from followspot.rotation import inverse, multiply, rotation_vector, turned
from followspot.tracking import Positions
from scripting import options_of

NOISE = 0.003
"""Sigma of a position along each axis, m."""
GAPS = (0.1, 0.25, 0.5, 1.0)
"""s after the last position."""
CYCLE = 3.0
"""Between the beginnings of two gaps, s."""
LEARNING = 15.0
"""Motion before the first gap that counts, s."""
NANOSECONDS = 1e9
BASELINE = {
    "02": ([6, 10, 12, 26, 22, 36, 51, 89], [2.3, 2.3, 0.4]),
    "07": ([8, 18, 15, 41, 21, 55, 51, 101], [1.8, 1.5, 1.0]),
    "10": ([6, 12, 11, 20, 22, 39, 50, 90], [0.5, 0.4, 0.3]),
    "15": ([7, 11, 14, 21, 24, 39, 54, 91], [1.0, 0.8, 0.5]),
    "30": ([10, 18, 26, 40, 44, 79, 82, 179], [3.3, 3.1, 1.2]),
    "34": ([6, 10, 12, 24, 28, 50, 64, 117], [1.8, 1.7, 0.6]),
}
"""By trial: errors in mm, orientation in degrees."""


@dataclass(frozen=True)
class Setting:
    """How positions and readings reach the filter.

    rate: of the positions, Hz; delay: added to the readings' time stamps, s; turn: (4,), from the recorded
    axes of the sensor to those that the filter gets; start, end: of the run, s; batch: readings of a message.
    """

    rate: float = 57.0
    delay: float = 0.0
    turn: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    start: float = 0.0
    end: float = np.inf
    batch: int = 5


@dataclass(frozen=True, eq=False)
class Result:
    """What came of M frames.

    error, sigma: (M, 3) m, NaN where no position was given; turn_error: (M, 3) rad, about the axes of the
    room; turn_sigma: (M,) rad; hidden, moved: (M,) s, since the last position and the first motion.
    """

    error: Array
    sigma: Array
    turn_error: Array
    turn_sigma: Array
    hidden: Array
    moved: Array


def hidden_at(times: Array, begins: float) -> Array:
    """Time since the last position of each frame, s; 0 if it is seen. begins: of the first gap, s."""
    phase = (times - begins) % CYCLE
    gap = (times >= begins) & (phase < GAPS[-1] + 0.03)
    seen = np.where(gap, -np.inf, times)
    return np.asarray(np.where(gap, times - np.maximum.accumulate(seen), 0.0))


def stages(rate: float, **params: float) -> tuple[Stage, Stage]:
    """The two stages in a room with one target that carries the sensor. rate: of the sensor, Hz."""
    sensor = Sensor("imu", "imu", rate=rate, mount=Member("targets", "board"))
    room = Room(targets={"board": Target("board", 0.05)}, sensors={"imu": sensor})
    orientation = load_stage("imu.orientation")(
        Context(name="orientation/imu", room=room, member=Member("sensors", "imu"))
    )
    track = load_stage("balls.inertial")(Context(name="track", room=room), **params)
    orientation.setup()
    track.setup()
    return orientation, track


def messages(trial: Trial, setting: Setting) -> Iterator[Inertial]:
    """The readings in batches."""
    time = np.rint((trial.time + setting.delay) * NANOSECONDS).astype(np.int64)
    turn = np.array(setting.turn)
    rates, forces = turned(turn, trial.turn_rate), turned(turn, trial.specific_force)
    first = int(np.searchsorted(trial.time, setting.start))
    for row in range(first, len(time), setting.batch):
        part = slice(row, row + setting.batch)
        unknown = np.full_like(rates[part], np.nan)
        yield seal(at(int(time[part][-1]), Inertial("imu", time[part], rates[part], forces[part], unknown)))


def measured(xyz: Array | None) -> Positions:
    """The position of the only target, (3,) m; without rows if it was not seen."""
    shapes = {c.name: [1 if isinstance(size, str) else size for size in c.shape] for c in Positions.columns}
    row = {c.name: np.zeros(shapes[c.name], c.dtype) for c in Positions.columns}
    if xyz is None:
        return Positions(**row).where(slice(0))
    row |= {"xyz": xyz[None], "covariance": np.eye(3)[None] * NOISE**2}
    return Positions(**row | {"support": np.full(1, 9, np.int32), "confirmed": np.ones(1, bool)})


def run(trial: Trial, setting: Setting, seed: int, **params: float) -> Result:
    """Track one trial. params: of `balls.inertial`."""
    rng = np.random.default_rng(seed)
    begun = max(setting.start, float(trial.time[trial.moving.argmax()]))
    times = np.arange(setting.start + 0.1, min(setting.end, trial.time[-1]) - 0.1, 1 / setting.rate)
    xyz, quaternion = truth_at(trial, times)
    noisy = xyz + NOISE * rng.normal(size=xyz.shape)
    hidden = hidden_at(times, begun + LEARNING + rng.uniform(0, CYCLE))
    tracked = list(_tracked(trial, setting, times, noisy, (hidden > 0) | np.isnan(noisy[:, 0]), params))
    rows = {name: np.array([found[name] for found in tracked]) for name in ("xyz", "sigma", "q", "q_sigma")}
    turn_error = rotation_vector(multiply(multiply(rows["q"], np.array(setting.turn)), inverse(quaternion)))
    moving = trial.moving[np.searchsorted(trial.time, times)]
    moved = np.where(moving, times - begun, -1.0)
    return Result(rows["xyz"] - xyz, rows["sigma"], turn_error, rows["q_sigma"], hidden, moved)


def _tracked(
    trial: Trial, setting: Setting, times: Array, noisy: Array, unseen: Array, params: dict[str, float]
) -> Iterator[dict[str, Array]]:
    """The estimate of the filter in each frame; NaN if it has none."""
    orientation, track = stages(1 / (trial.time[1] - trial.time[0]), **params)
    source = messages(trial, setting)
    waiting = next(source, None)
    for time, xyz, hidden in zip(np.rint(times * NANOSECONDS).astype(np.int64), noisy, unseen, strict=True):
        readings, turns = [], []
        while waiting is not None and waiting.header.time <= time:
            readings.append(waiting)
            found = orientation.process(waiting)
            turns += [] if found is None else [seal(at(waiting.header.time, found))]
            waiting = next(source, None)
        message = seal(at(int(time), measured(None if hidden else xyz)))
        yield _row(track.process(message, tuple(readings), tuple(turns)).tracks)


def _row(tracks: PosedTracks) -> dict[str, Array]:
    if not len(tracks.target):
        sizes: dict[str, tuple[int, ...]] = {"xyz": (3,), "sigma": (3,), "q": (4,), "q_sigma": ()}
        return {name: np.full(size, np.nan) for name, size in sizes.items()}
    return {
        "xyz": tracks.xyz[0],
        "sigma": tracks.sigma[0],
        "q": tracks.quaternion[0],
        "q_sigma": tracks.orientation_sigma[0],
    }


def figures(results: Sequence[Result], rate: float) -> dict[str, list[float]]:
    """Errors at the ends of gaps (mm), shares (%) and orientation (degrees) over the runs of one trial."""
    joined = {name: np.concatenate([getattr(r, name) for r in results]) for name in Result.__annotations__}
    counts = joined["moved"] >= LEARNING
    length = 1e3 * np.linalg.norm(joined["error"], axis=1)
    ends = []
    for gap in GAPS:
        end = counts & (np.rint(joined["hidden"] * rate) == round(gap * rate))
        ends += [float(np.nanmedian(length[end])), float(np.nanpercentile(length[end], 95))]
    hidden = counts & (joined["hidden"] > 0)
    given = hidden & np.isfinite(length)
    inside = np.abs(joined["error"][given]) <= 1.96 * joined["sigma"][given]
    turn = np.degrees(joined["turn_error"][counts & np.isfinite(joined["turn_error"]).all(axis=1)])
    total, heading = np.linalg.norm(turn, axis=1), turn[:, 2]
    inclination = np.linalg.norm(turn[:, :2], axis=1)
    return {
        "gap_mm": ends,
        "inside_percent": [100 * float(inside.mean()), 100 * float(given.sum() / max(hidden.sum(), 1))],
        "orientation_deg": [float(np.sqrt(np.mean(np.square(e)))) for e in (total, heading, inclination)],
        "orientation_sigma_deg": [float(np.degrees(np.nanmedian(joined["turn_sigma"][counts])))],
    }


def turned_at_random(seed: int) -> tuple[float, ...]:
    """A random rotation, (4,)."""
    q = np.random.default_rng(seed).normal(size=4)
    return tuple((q / np.linalg.norm(q)).tolist())


def main() -> None:
    """Measure and print a table."""
    parser = options_of(__doc__)
    parser.add_argument("folder", type=Path, help="of the trials")
    parser.add_argument("--trials", nargs="*", default=[], help="first two digits; all without")
    parser.add_argument("--seeds", type=int, default=1, help="runs of each trial with other noise and gaps")
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--rate", type=float, default=57.0, help="of the positions, Hz")
    parser.add_argument("--delay", type=float, default=0.0, help="of the readings' time stamps, s")
    parser.add_argument("--start", type=float, default=0.0, help="leave out the first seconds")
    parser.add_argument("--turned", type=int, default=None, help="turn the sensor's axes at random: a seed")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=NUMBER", help="of balls.inertial")
    args = parser.parse_args()
    params = {key: float(value) for key, value in (option.split("=") for option in args.set)}
    turn = (1.0, 0.0, 0.0, 0.0) if args.turned is None else turned_at_random(args.turned)
    setting = Setting(args.rate, args.delay, turn, args.start)
    result = {}
    if not args.json:
        print("trial  0.1 s    0.25 s   0.5 s    1.0 s     inside given  orientation")
    for path in sorted(args.folder.glob("*.npz")):
        if args.trials and path.name[:2] not in args.trials:
            continue
        trial = read(path)
        runs = [run(trial, setting, args.first_seed + seed, **params) for seed in range(args.seeds)]
        result[trial.name] = figures(runs, args.rate)
        if not args.json:
            _print(trial.name, result[trial.name])
    if args.json:
        print(json.dumps(result))


def _print(name: str, row: dict[str, list[float]]) -> None:
    pairs = list(zip(row["gap_mm"][::2], row["gap_mm"][1::2], strict=True))
    inside, given = row["inside_percent"]
    angles = " / ".join(f"{angle:.2f}" for angle in row["orientation_deg"])
    sigma = row["orientation_sigma_deg"][0]
    cells = " ".join(f"{median:3.0f}/{tail:<4.0f}" for median, tail in pairs)
    print(f"{name:<5} {cells}   {inside:5.1f} {given:5.1f}   {angles} (sigma {sigma:.2f})", flush=True)
    if name in BASELINE:
        errors, angles_then = BASELINE[name]
        cells = " ".join(f"{m:3.0f}/{p:<4.0f}" for m, p in zip(errors[::2], errors[1::2], strict=True))
        print(f"{'':<5} {cells}   {'':11}   {' / '.join(f'{angle:.2f}' for angle in angles_then)}")


if __name__ == "__main__":
    main()
