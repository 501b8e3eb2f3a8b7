"""Messages to draw, and the pictures that `sinks.draw` makes of them."""

from pathlib import Path

import numpy as np

from followspot import Camera, Context, Header, Room, Target
from followspot.messages import stamped
from followspot.people import Poses
from followspot.tracking import Frame
from followspot_sinks.draw import Draw

ALONG_X = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
SIZE = (640, 480)


def camera(name: str = "left", model: str = "pinhole") -> Camera:
    """A level camera 1.2 m above the origin that looks along x."""
    f, size = (460.0, SIZE) if model == "pinhole" else (100.0, (628, 200))
    K = np.array([[f, 0, (size[0] - 1) / 2], [0, f, (size[1] - 1) / 2], [0, 0, 1]])
    distortion = np.zeros(5 if model == "pinhole" else 0)
    return Camera(name, "color", size, K, distortion, ALONG_X, -ALONG_X @ [0, 0, 1.2], model)  # type: ignore[arg-type]


ROOM = Room(cameras={"left": camera(), "right": camera("right")}, targets={"red": Target("red", 0.1)})


def frame(seq: int = 0, name: str = "left", size: tuple[int, int] = SIZE, channels: int = 3) -> Frame:
    pixels = np.zeros((size[1], size[0], channels), "u1")
    return stamped(Frame(camera=name, pixels=pixels), Header(f"camera/{name}", seq, seq * 100_000_000))


def poses(seen_by: str = "left", place: tuple[float, float] = (3.0, 0.0), heading: float = np.pi) -> Poses:
    return Poses(
        camera=seen_by,
        person=np.array([1], "i4"),
        state=np.ones(1, "u1"),
        xy=np.array([place]),
        height=np.array([1.75]),
        heading=np.array([heading]),
        pan=np.zeros(1),
        tilt=np.zeros(1),
        sigma=np.zeros((1, 6)),
        confidence=np.ones(1),
    )


def drawn(folder: Path, room: Room, *inputs: tuple[object, ...]) -> Path:
    sink = Draw(Context(room=room, out=folder), format="png")
    sink.setup()
    sink.process(*inputs)  # type: ignore[arg-type]
    sink.close()
    return folder / "drawn"
