"""Bytes and CPU time of exact pictures in a recording, by compression; all ways in turns.

    python tools/bench/recording/recorded_bytes.py
    python tools/bench/recording/recorded_bytes.py --video cam0.mkv --video room.mp4 --rounds 5 --json

`rows` is what `--record-compression zstd` writes; FFV1 is tried if PyAV is installed. Every way is read
again, and must give the same bits. Pictures with noise of 3 gray levels, as of a sensor, come first.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import importlib.util
import json
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import cv2
import lz4.frame
import numpy as np
import zstandard

from benching.lossless_video import LosslessVideo
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, stamped
from followspot.tracking import Frame
from followspot.wire import differenced, pack, restored
from scripting import options_of

_CHUNK = 4 << 20
"""Bytes of a chunk, as recordings have them."""
_LEVEL = 1
Packed = list[bytes]


@dataclass(frozen=True)
class Way:
    """A compression: packed messages to blocks of the file, and back."""

    write: Callable[[Packed], Packed]
    read: Callable[[Packed], Packed]


def _chunks(messages: Packed) -> Packed:
    count = max(1, _CHUNK // len(messages[0]))
    return [b"".join(messages[i : i + count]) for i in range(0, len(messages), count)]


def _messages(chunks: Packed, size: int) -> Packed:
    return [chunk[i : i + size] for chunk in chunks for i in range(0, len(chunk), size)]


def ways(size: int) -> dict[str, Way]:
    """The compressions by name; size: bytes of a message."""
    unzip = zstandard.ZstdDecompressor().decompress
    zip_ = zstandard.ZstdCompressor(level=_LEVEL).compress
    return {
        "none": Way(_chunks, lambda found: _messages(found, size)),
        "lz4": Way(
            lambda given: list(map(lz4.frame.compress, _chunks(given))),
            lambda found: _messages(list(map(lz4.frame.decompress, found)), size),
        ),
        "zstd alone": Way(
            lambda given: list(map(zip_, _chunks(given))),
            lambda found: _messages(list(map(unzip, found)), size),
        ),
        "rows, zstd": Way(
            lambda given: list(map(zip_, _chunks(list(map(differenced, given))))),
            lambda found: [bytes(restored(m)) for m in _messages(list(map(unzip, found)), size)],
        ),
    }


def measure(pictures: Sequence[Array], rounds: int) -> dict[str, Mapping[str, float]]:
    """Share of the bytes, and MB of pictures a second of CPU time, by way."""
    packed = [
        pack(stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", n, n)))
        for n, pixels in enumerate(pictures)
    ]
    tried = ways(len(packed[0]))
    if importlib.util.find_spec("av") is not None:
        video = LosslessVideo(pictures[0].shape, len(packed[0]))
        tried["FFV1 (PyAV)"] = Way(video.write, video.read)
    total = sum(map(len, packed)) / 1e6
    writing: dict[str, list[float]] = {name: [] for name in tried}
    reading: dict[str, list[float]] = {name: [] for name in tried}
    shares = {}
    for _ in range(rounds):
        for name, way in tried.items():
            began = time.process_time()
            blocks = way.write(packed)
            wrote = time.process_time()
            again = way.read(blocks)
            writing[name].append(total / max(1e-9, wrote - began))
            reading[name].append(total / max(1e-9, time.process_time() - wrote))
            shares[name] = sum(map(len, blocks)) / 1e6 / total
            if again != packed:
                raise SystemExit(f"{name} does not give the same bits")
    return {
        name: {"share": shares[name], "write": median(writing[name]), "read": median(reading[name])}
        for name in tried
    }


def noisy(count: int) -> list[Array]:
    """Pictures of 320x240 with the noise of a sensor."""
    rng = np.random.default_rng(0)
    scene = np.linspace(20, 120, 320)[None, :, None] + np.zeros((240, 320, 3))
    return [np.clip(rng.normal(scene, 3.0), 0, 255).astype("u1") for _ in range(count)]


def film(path: Path, count: int) -> list[Array]:
    """The first pictures of a video."""
    capture = cv2.VideoCapture(str(path))
    found = [pixels for there, pixels in (capture.read() for _ in range(count)) if there]
    if not found:
        raise SystemExit(f"{path} has no pictures")
    return found


def main() -> int:
    """Measure and print."""
    parser = options_of(__doc__)
    parser.add_argument("--video", type=Path, action="append", default=[], help="pictures of a video, too")
    parser.add_argument("--frames", type=int, default=60, help="of each (default 60)")
    parser.add_argument("--rounds", type=int, default=3, help="how often, in turns (default 3)")
    args = parser.parse_args()
    films = {path.name: film(path, args.frames) for path in args.video}
    found: dict[str, Any] = {}
    for name, pictures in ({"noise of 3 gray levels": noisy(args.frames)} | films).items():
        found[name] = measure(pictures, args.rounds)
    if args.json:
        print(json.dumps(found))
        return 0
    for name, rows in found.items():
        print(f"{name}: share of the bytes, MB/s written, MB/s read (CPU time)")
        for way, row in rows.items():
            print(f"  {way:12} {row['share']:6.3f} {row['write']:6.0f} {row['read']:6.0f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
