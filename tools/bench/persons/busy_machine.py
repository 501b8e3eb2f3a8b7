"""People before one live camera on a busy machine: coverage and errors beside programs that never rest.

    python tools/bench/persons/busy_machine.py --room room.yaml --others 0 6

The room's camera plays its recording at its own pace, as a live one, with truth beside it. The slow instance
has a worker of its own (`graphs/placements/person.yaml`), so its detections come late when others hold the
cores; `dropped` are pictures that it had no time for. The others are in the session of the run: where the
system groups sessions, it deals cores out to these first.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from math import nan
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from bench.runtime.busy_machine import burners
from followspot.room_file import load, save
from scripting import followspot, shown, table_options

ROOT = Path(__file__).parents[3]
WORDS = (ROOT / "graphs/person_panorama.yaml", "--placement", ROOT / "graphs/placements/person.yaml")


def main() -> None:
    """Run in turns; print medians."""
    args = parser().parse_args()
    found: dict[int, list[dict[str, Any]]] = {count: [] for count in args.others}
    with TemporaryDirectory(prefix="followspot-busy-") as name:
        room = played(args.room, Path(name))
        for number in range(args.rounds):
            for count in args.others:
                found[count].append(run(room, count, args.frames, Path(name)))
                print(f"round {number + 1}, {count} others: {found[count][-1]}", file=sys.stderr)
    rows = [
        {"others": count, **{key: median(told[key] for told in runs) for key in runs[0]}}
        for count, runs in found.items()
    ]
    if args.json:
        print(json.dumps(rows))
        return
    print(shown(args, list(rows[0]), [[f"{value:.3g}" for value in row.values()] for row in rows]))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--room", required=True, help="room file whose one camera plays a video, with truth")
    options.add_argument("--others", nargs="+", type=int, default=[0, 6], help="programs that never rest")
    options.add_argument("--frames", type=int, default=200, help="of each run (default %(default)s)")
    options.add_argument("--rounds", type=int, default=1, help="(default %(default)s)")
    return options


def played(file: str, folder: Path) -> Path:
    """The room with its camera playing at the pace of the recording, as a live one."""
    room = load(file)
    cameras = {}
    for name, camera in room.cameras.items():
        if camera.source is None or camera.source.uses != "cameras.video":
            raise SystemExit(f'{file}: camera "{name}" plays no video: give a room with `cameras.video`')
        path = Path(camera.source.folder) / str(camera.source.params["path"])
        source = replace(
            camera.source, uses="cameras.playback", params={**camera.source.params, "path": str(path)}
        )
        cameras[name] = replace(camera, source=source)
    written = folder / "room.yaml"
    save(replace(room, cameras=cameras), written)
    return written


def run(room: Path, others: int, frames: int, folder: Path) -> dict[str, float]:
    """One run beside so many others."""
    with burners(others):
        told = followspot("run", *WORDS, "--room", room, "--frames", str(frames), "--out", folder / "out")
    if not told["ok"]:
        raise SystemExit("\n".join(told["errors"]))
    everybody = told["persons"]["all"]
    (sampled,) = (edge for edge in told["edges"] if edge["to"].startswith("sampler/"))
    (path,) = (path for path in told["paths"] if path["to"] == "save")
    figures = {
        "coverage, %": 100 * everybody["coverage"],
        "position, cm": everybody["position_cm"]["median"],
        "torso, deg": everybody["torso"]["median_deg"],
        "false, %": 100 * everybody["false_share"],
        "switches": everybody["identity_switches"],
        "p50, ms": path["p50_ms"],
        "searched": sampled["delivered"],
        "dropped": sampled["dropped"],
    }
    return {name: nan if value is None else value for name, value in figures.items()}


if __name__ == "__main__":
    main()
