"""Targets: files that users write, get from others, or take from elsewhere."""

from __future__ import annotations

import io
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import followspot_accuracy as accuracy
from followspot import room_file
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot_accuracy.persons.tables import POSE_COLUMNS, TRUTH_COLUMNS
from followspot_calibrate.points_file.reading import read_points
from followspot_room.calibration import read_calibration
from fuzzing.mutation import broken_bytes, broken_text
from fuzzing.target import Target

ROOT = Path(__file__).parents[2]
Mutation = Callable[[bytes, random.Random, Sequence[bytes]], bytes]


def _file_target(
    samples: Sequence[bytes], name: str, read: Callable[[Path], object], broken: Mutation = broken_text
) -> Target:
    """Files with this name, broken, each read from the disk as a user's would be."""
    folder = TemporaryFolder("fuzz")

    def take(data: bytes) -> object:
        path = folder.path / name
        path.write_bytes(data)
        return read(path)

    return Target(lambda rng: broken(rng.choice(samples), rng, samples), take, (FollowspotError,))


def _texts(folder: Path, pattern: str, most: int = 30_000) -> list[bytes]:
    texts = [path.read_bytes() for path in sorted(folder.glob(pattern))]
    return [text for text in texts if len(text) <= most]


def graph_target() -> Target:
    """Graph files: compiled to a plan, nothing started."""
    room = str(ROOT / "graphs/rooms/simulated.yaml")
    return _file_target(
        _texts(ROOT / "graphs", "*.yaml"), "g.yaml", lambda path: compile_graph(path, room=room)
    )


def room_target() -> Target:
    """Room files, and a graph in such a room."""
    graph = ROOT / "graphs/glowballs.yaml"

    def read(path: Path) -> object:
        room_file.load(path)
        return compile_graph(graph, room=path)

    return _file_target(_texts(ROOT / "graphs/rooms", "*.yaml"), "room.yaml", read)


def placement_target() -> Target:
    """Placement files."""
    room, graph = ROOT / "graphs/rooms/simulated.yaml", ROOT / "graphs/glowballs.yaml"
    samples = _texts(ROOT / "graphs/placements", "*.yaml")
    return _file_target(samples, "p.yaml", lambda path: compile_graph(graph, room=room, placement=path))


def override_target() -> Target:
    """`--set` options."""
    graph = ROOT / "graphs/glowballs.yaml"
    samples = [
        b"fuse.uses=balls.mean",
        b"color.similarity=0.9",
        b"track.in.positions=fuse",
        b"room=x",
        b"a.b={c: [1]}",
    ]

    def take(data: bytes) -> object:
        return compile_graph(graph, overrides=[data.decode("utf-8", "replace")])

    return Target(lambda rng: broken_text(rng.choice(samples), rng, samples), take, (FollowspotError,))


TRACKS = b"""frame,time,object,state,x,y,z,vx,vy,vz,sx,sy,sz
0,0.0,green,tracked,0.1,0.2,1.0,0,0,0,0.01,0.01,0.01
1,0.016,green,predicted,0.1,0.2,1.0,0,0,0,0.01,0.01,0.01
1,0.016,red,tracked,-1e-3,2.5,1.0,0.1,0,0,0.01,0.01,0.01
"""
TRUTH = b"frame,time,object,x,y,z\n0,0.0,green,0.1,0.2,1.0\n1,0.016,green,0.1,0.2,1.0\n"
POINTS = b"frame,camera,u,v,point\n0,cam0,12.5,33,wand\n0,cam1,100,50.25,wand\n1,cam0,13,34,wand\n"


def _table(columns: Sequence[str]) -> bytes:
    rows = [
        ",".join(columns),
        *(",".join(f"{row + place / 10}" for place in range(len(columns))) for row in (0, 1)),
    ]
    return "\n".join(rows).encode()


def tables_target() -> Target:
    """CSV files of tracks, truth and points."""
    readers: list[Callable[[Path], object]] = [
        accuracy.read_tracks_csv,
        accuracy.read_truth_csv,
        lambda path: accuracy.read_poses_csv(path, lambda camera: np.zeros(2)),
        accuracy.read_pose_truth_csv,
        lambda path: read_points(path, size=(320, 240)),
    ]
    samples = [TRACKS, TRUTH, _table(POSE_COLUMNS), _table(TRUTH_COLUMNS), POINTS]
    folder = TemporaryFolder("fuzz")

    def make(rng: random.Random) -> tuple[int, bytes]:
        number = rng.randrange(len(readers))
        sample = samples[number] if rng.random() < 0.9 else rng.choice(samples)
        return number, broken_text(sample, rng, samples)

    def take(made: tuple[int, bytes]) -> object:
        path = folder.path / "table.csv"
        path.write_bytes(made[1])
        return readers[made[0]](path)

    return Target(make, take, (FollowspotError,))


def keypoints_target() -> Target:
    """NumPy files of keypoints."""
    kept = io.BytesIO()
    np.savez_compressed(kept, keypoints=np.ones((2, 3, 1, 3)), views_xywh=np.full((2, 4), 320))
    plain = io.BytesIO()
    np.savez(plain, keypoints=np.ones((2, 3, 1, 3)), views_xywh=np.full((2, 4), 320))
    samples = [kept.getvalue(), plain.getvalue()]

    def read(path: Path) -> object:
        return read_points(path, size=(320, 240))

    return _file_target(samples, "k.npz", read, broken_bytes)


def calibration_target() -> Target:
    """Calibrations in all formats that can be imported."""
    from followspot_room.calibration import FORMATS

    cameras = list(room_file.load(ROOT / "graphs/rooms/simulated.yaml").cameras.values())
    samples: list[bytes] = []
    for known in FORMATS:
        if known.write is not None and not known.folder:
            samples += [text.encode() for text in _written(known.write, cameras).values()]
    samples += [
        b'<?xml version="1.0"?><calibration><cameras><camera serial="1"/></cameras></calibration>',
        b"%YAML:1.0\n---\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
        b"   data: [1,0,0,0,1,0,0,0,1]\n",
    ]
    return _file_target(samples, "calibration", read_calibration)


def _written(write: Callable[[Any], Any], cameras: list[Any]) -> dict[str, str]:
    try:
        return dict(write(cameras))
    except Exception as error:
        raise SystemExit(f"a format cannot write the simulated room: {error}") from error
