"""Crops of simulated people to train the detector of upper bodies with, and their rooms without people.

    python tools/render_crops.py --seeds 9000 9064 -o runs/crops
    followspot train hog runs/crops -o hog_weights.npz

Each seed is another room with other people, half of the rooms seen by a panorama, half by a perspective
camera. `boxes.csv` has body, room and headings of each crop; the rooms have four names in turn, so that every
fourth is held out of a trial. Nothing of it is from recordings, and none of it needs a licence.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benching.person_stages import build_stage
from followspot import Array, Camera, Room
from followspot.geometry import project, wrap
from followspot.people import PoseTruth
from followspot.room_file import load
from followspot_persons.body.standing import WAIST
from followspot_persons.hog.window import cut
from scripting import options_of

ROOMS = Path(__file__).parent.parent / "graphs" / "rooms"
VIEWS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("simulated_panorama.yaml", {"clear_radius": 0.9}),
    ("simulated_persons.yaml", {}),
)
"""Rooms, and what is other in them."""
PEOPLE, PLACES = 2, 4
"""People of a room, and names of rooms."""
MARGIN = 16
"""Margin of a crop about the detector's window, px."""
SMALLEST = 28.0
"""Smallest height of an upper body, px."""
SEEN = 0.5
"""Smallest visible share of a person."""
INTERVAL = 1.1
"""Time between two crops of a person, s."""


def main() -> None:
    """Render; print how many crops there are."""
    parser = options_of(__doc__)
    parser.add_argument("--seeds", nargs=2, type=int, required=True, metavar=("FIRST", "END"))
    parser.add_argument("--pictures", type=int, default=8, help="of each room with people")
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder to write to")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    rows = [row for seed in range(*given.seeds) for row in crops(given.out, seed, given.pictures)]
    with (given.out / "boxes.csv").open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["file", "body", "room", "torso_heading", "head_pan"])
        table.writerows(rows)
    print(f"{len(rows)} crops in {given.out}")


def crops(out: Path, seed: int, pictures: int) -> Iterator[tuple[str, int, str, float, float]]:
    """Write the empty room and the crops of a seed; gives their rows of `boxes.csv`."""
    file, other = VIEWS[seed // PLACES % len(VIEWS)]
    place = f"simulated{seed % PLACES}"
    room, truth = played(load(ROOMS / file), {**other, "people": 0, "seed": seed, "frames": 1})
    cv2.imwrite(str(out / f"neg_{place}_{seed}.jpg"), next(shown(room)))
    params = {**other, "people": PEOPLE, "seed": seed, "frames": pictures, "fps": 1 / INTERVAL}
    room, truth = played(load(ROOMS / file), params)
    camera = next(iter(room.cameras.values()))
    for number, (pixels, true) in enumerate(zip(shown(room), truth, strict=True)):
        for person, box in enumerate(upper_bodies(camera, true)):
            if true.visible[person] < SEEN or not usable(camera, box):
                continue
            name = f"{seed}_{number}_{person}.jpg"
            cv2.imwrite(str(out / name), cut(pixels, box, MARGIN), [cv2.IMWRITE_JPEG_QUALITY, 95])
            to_camera = np.arctan2(*(camera.center[:2] - true.xy[person])[::-1])
            heading = float(wrap(true.heading[person] - to_camera))
            # people of one room are held out with it: their numbers have the same remainder as its name
            yield name, seed + 100_000 * person, place, round(heading, 3), round(float(true.pan[person]), 3)


def played(room: Room, params: dict[str, Any]) -> tuple[Room, Iterator[PoseTruth]]:
    """The room with its first camera alone and these parameters, and the true poses of each frame."""
    camera = next(iter(room.cameras.values()))
    assert camera.source is not None
    assert room.truth is not None
    source = replace(camera.source, params={**camera.source.params, **params})
    changed = replace(room, cameras={camera.name: replace(camera, source=source)})
    truth = build_stage(room.truth.uses, changed, **{**room.truth.params, **params})
    return changed, islice(truth.process(), params["frames"])


def shown(room: Room) -> Iterator[Array]:
    """The pictures of the room's camera, (H, W, 3) u1."""
    camera = next(iter(room.cameras.values()))
    assert camera.source is not None
    source = build_stage(camera.source.uses, room, **camera.source.params)
    for frame in source.process():
        yield frame.pixels.copy()
    source.close()


def upper_bodies(camera: Camera, true: PoseTruth) -> Array:
    """Boxes of upper bodies from head top to waist, (P, 4) px."""
    top = project(camera, np.column_stack([true.xy, true.height]))
    waist = project(camera, np.column_stack([true.xy, WAIST * true.height]))
    middle, half = (top[:, 0] + waist[:, 0]) / 2, (waist[:, 1] - top[:, 1]) / 3
    return np.column_stack([middle - half, top[:, 1], middle + half, waist[:, 1]])


def usable(camera: Camera, box: Array) -> bool:
    """Whether a crop about a box (4,) px lies mostly in the picture and shows a body that is large enough."""
    width, height = camera.size
    tall = box[3] - box[1]
    return bool(
        tall >= SMALLEST
        and box[0] > 0
        and box[2] < width
        and box[1] > -0.05 * tall
        and box[1] < height - tall
    )


if __name__ == "__main__":
    main()
