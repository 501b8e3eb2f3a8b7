"""Leave-one-out choice of `balls.inertial`'s errors of scale on real trials.

    python tools/choose_inertial.py FOLDER --values 0.001 0.002 0.004

Each value is given to gyroscope and accelerometer alike. Its share of hidden positions within 1.96 sigma,
along each axis, should be 95 %. For each trial the value is chosen whose share over the other trials is
nearest to that, in the logarithm of the odds, and judged on the trial that was left out.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from bench.balls import inertial
from bench.balls.inertial import Setting
from benching.inertial_trial import read
from scripting import options_of

WANTED = 0.95
"""Share of a normal distribution within 1.96 sigma."""

Shares = Mapping[str, Mapping[float, float]]
"""Share within 1.96 sigma by trial and value."""


def distance(share: float) -> float:
    """How far a share is from the wanted one: difference of the logarithms of the odds."""
    odds = np.clip(share, 0.001, 0.999)
    return float(abs(np.log(odds / (1 - odds)) - np.log(WANTED / (1 - WANTED))))


def chosen(shares: Shares, left_out: str) -> float:
    """The value that is nearest to honest over the other trials."""
    others = [of for name, of in shares.items() if name != left_out]
    return min(others[0], key=lambda value: distance(float(np.mean([of[value] for of in others]))))


def measured(folder: Path, values: list[float], setting: Setting, seed: int) -> dict[str, dict[float, float]]:
    """The shares of all trials of a folder."""
    shares: dict[str, dict[float, float]] = {}
    for path in sorted(folder.glob("*.npz")):
        trial = read(path)
        shares[trial.name] = {}
        for value in values:
            params = {"gyroscope_scale": value, "accelerometer_scale": value}
            runs = [inertial.run(trial, setting, seed, **params)]
            found = inertial.figures(runs, setting.rate)["inside_percent"][0]
            shares[trial.name][value] = found / 100
    return shares


def main() -> None:
    """Measure, choose and print a table."""
    parser = options_of(__doc__)
    parser.add_argument("folder", type=Path, help="of the trials")
    parser.add_argument("--values", type=float, nargs="+", default=[0.001, 0.002, 0.004])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--start", type=float, default=0.0, help="leave out the first seconds")
    parser.add_argument("--end", type=float, default=float("inf"), help="of the runs, s")
    args = parser.parse_args()
    shares = measured(args.folder, args.values, Setting(start=args.start, end=args.end), args.seed)
    if args.json:
        print(
            json.dumps({name: {"shares": of, "chosen": chosen(shares, name)} for name, of in shares.items()})
        )
        return
    print("trial  " + "  ".join(f"{value:7g}" for value in args.values) + "  chosen by the others: within")
    for name, of in shares.items():
        value = chosen(shares, name)
        cells = "  ".join(f"{100 * of[v]:5.1f} %" for v in args.values)
        print(f"{name:<5}  {cells}  {value:g}: {100 * of[value]:.1f} %")


if __name__ == "__main__":
    main()
