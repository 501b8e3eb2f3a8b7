"""Render the small recordings in `tests/rendered`, which let tests run without any other data.

    python tools/render_tests.py

Balls: 4 s of the simulated room as another seed than the demo's plays it, with clips of each ball alone.
People: some pictures of the three cameras of their room. Both are compressed as cameras do (H.264), and have
calibrations and ground truth. Nothing of it is from recordings, and none of it needs a licence.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

from followspot import Camera, Room
from followspot.room_file import load
from followspot_sim.actor.recording import actor_parameters_of, record_people
from followspot_sim.recording import parameters_of, record, record_templates
from scripting import options_of

ROOT = Path(__file__).resolve().parents[1]
ROOMS = ROOT / "graphs" / "rooms"
RENDERED = ROOT / "tests" / "rendered"
BALL_FRAMES, TEMPLATE_FRAMES, PEOPLE_FRAMES = 120, 12, 24
BALL_FPS, SEED = 30.0, 21
BALL_QUALITY, PEOPLE_QUALITY = 18, 22
"""Constant rate factors of H.264: the larger, the smaller the files."""


def balls(folder: Path) -> None:
    """The simulated room: six videos, their calibration and truth, and clips of each ball alone."""
    room = load(ROOMS / "simulated.yaml")
    params = parameters_of(room, frames=BALL_FRAMES, seed=SEED).model_copy(update={"fps": BALL_FPS})
    record(room, params, folder)
    record_templates(room, params, folder / "templates", TEMPLATE_FRAMES)
    for video in sorted(folder.rglob("*.mkv")):
        compress(video, BALL_FPS, BALL_QUALITY)
    radius = next(iter(room.targets.values())).radius
    _write_calibration(room, folder, {"ball_radius_m": radius})


def people(folder: Path) -> None:
    """The room with people: three videos, their calibration and the true poses."""
    room = load(ROOMS / "simulated_persons.yaml")
    params = actor_parameters_of(room, frames=PEOPLE_FRAMES, seed=SEED)
    record_people(room, params, folder)
    for video in sorted(folder.glob("*.mkv")):
        compress(video, params.fps, PEOPLE_QUALITY)
    _write_calibration(room, folder, {})


def compress(video: Path, fps: float, quality: int) -> None:
    """Encode a lossless video anew, in its place."""
    small = video.with_suffix(".small.mkv")
    pictures = cv2.VideoCapture(str(video))
    with av.open(str(small), "w") as container:
        stream = container.add_stream(
            "libx264", rate=Fraction(fps), options={"crf": str(quality), "preset": "veryslow"}
        )
        stream.width = int(pictures.get(cv2.CAP_PROP_FRAME_WIDTH))
        stream.height = int(pictures.get(cv2.CAP_PROP_FRAME_HEIGHT))
        stream.pix_fmt = "yuv420p"
        while (read := pictures.read())[0]:
            pixels = np.asarray(read[1], np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="bgr24")))
        container.mux(stream.encode())
    small.replace(video)


def _write_calibration(room: Room, folder: Path, more: dict[str, float]) -> None:
    planes = {name: plane.tolist() for name, plane in room.planes.items()}
    document = {"cameras": [_calibrated(c) for c in room.cameras.values()], "planes": planes, **more}
    (folder / "calibration.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def _calibrated(camera: Camera) -> dict[str, object]:
    return {
        "name": camera.name,
        "kind": camera.kind,
        "width": camera.size[0],
        "height": camera.size[1],
        "K": camera.matrix.tolist(),
        "dist": camera.distortion.tolist(),
        "R": camera.rotation.tolist(),
        "t": camera.translation.tolist(),
    }


def main() -> None:
    """Replace the recordings."""
    parser = options_of(__doc__)
    parser.add_argument("-o", "--out", type=Path, default=RENDERED, metavar="DIR", help="other folder")
    out: Path = parser.parse_args().out
    for name, render in (("balls", balls), ("people", people)):
        with tempfile.TemporaryDirectory() as made:
            render(Path(made))
            shutil.rmtree(out / name, ignore_errors=True)
            shutil.copytree(made, out / name)
        size = sum(file.stat().st_size for file in (out / name).rglob("*") if file.is_file())
        print(f"{out / name}: {size / 1e3:.0f} kB", file=sys.stderr)


if __name__ == "__main__":
    main()
