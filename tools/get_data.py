"""List the data sets that experiments and tests use, or fetch those that their licences let everybody have.

    python tools/get_data.py                   what there is, under which licence, and what is here
    python tools/get_data.py opencv-samples    fetch one into data/, where tests look for it

Nothing is fetched that is not named. A download that was cut off goes on; a file whose SHA-256 is not the
known one is refused. `make data NAMES="..."` does the same.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path

from public_data.download import DownloadError, download
from public_data.table import DataSet, data_sets
from scripting import options_of

DATA = Path(__file__).resolve().parents[1] / "data"
MB = 1e6


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code 0; 1 if something cannot be fetched, 2 for a name that is not in the table."""
    parser = options_of(__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="a data set to fetch")
    parser.add_argument("--to", type=Path, default=DATA, metavar="DIR", help="folder (default: data/)")
    args = parser.parse_args(arguments)
    known = data_sets()
    if unknown := [name for name in args.names if name not in known]:
        print(f"there is no data set {', '.join(unknown)}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    if args.json:
        print(json.dumps([asdict(one) | {"state": state(one, args.to)} for one in known.values()]))
    elif not args.names:
        _print(known.values(), args.to)
    return max((_fetch(known[name], args.to) for name in args.names), default=0)


def state(one: DataSet, folder: Path) -> str:
    """Whether the data set is in the folder, in words."""
    missing = one.missing(folder)
    if one.by_hand:
        return "here" if (folder / one.name).is_dir() else "by hand"
    if not missing:
        return "here"
    return f"{sum(file.size for file in missing) / MB:.1f} MB to fetch"


def _print(known: Iterable[DataSet], folder: Path) -> None:
    for one in known:
        print(f"{one.name}: {state(one, folder)}\n  {one.about}\n  licence: {one.licence}\n  {one.origin}")
        if one.by_hand:
            print(f"  not fetched: {one.by_hand}")
    print('\nmake data NAMES="opencv-samples ..." fetches what you name')


def _fetch(one: DataSet, folder: Path) -> int:
    if one.by_hand:
        print(f"{one.name} is not fetched: {one.by_hand} ({one.origin})", file=sys.stderr)
        return 1
    missing = one.missing(folder)
    for number, file in enumerate(missing, 1):
        print(f"{one.name}: {number} of {len(missing)}, {file.path}", file=sys.stderr)
        try:
            download(file, folder / one.name / file.path)
        except (DownloadError, OSError) as error:
            print(f"{one.name}: {error}", file=sys.stderr)
            return 1
    print(f"{one.name} is in {folder / one.name}. Licence: {one.licence}; from {one.origin}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
