"""Takes pictures of a camera on loopback in a process of its own, where the system's `gi` can be imported.

python aravis_trial.py CAMERA BACKEND COUNT: CAMERA (aravis, viva-genicam) runs, BACKEND takes COUNT pictures;
prints JSON.
"""

from __future__ import annotations

import json
import sys
import time
from collections import Counter
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path

SYSTEM = Path("/usr/lib/python3/dist-packages")
PERIOD, SIZE = 0x138, (64, 48)
"""Register of the frame period of Aravis' camera, us; the size of the pictures, px."""


@contextmanager
def running(camera: str):
    """A camera on 127.0.0.1, 250 frames a second."""
    if camera == "aravis":
        from gi.repository import Aravis

        fake = Aravis.GvFakeCamera.new("127.0.0.1", "GV01")
        fake.get_fake_camera().write_register(PERIOD, 4000)
        yield fake
        return
    from viva_genicam.testing import FakeGigeCamera

    with FakeGigeCamera(*SIZE, 100, packet_resend=False, drop_packets=[(5, 1), (9, 1)]) as fake:
        yield fake


def main(camera: str, backend: str, count: int) -> None:
    """Print what was taken."""
    import gi

    gi.require_version("Aravis", "0.8")
    from tests.plugins.cameras.recordings import context

    from followspot_cameras.genicam.backends import discovered
    from followspot_cameras.genicam.stage import Genicam

    stamps: dict[int, int] = {}

    class Watched(Genicam):
        def _is_whole(self, picture, camera):
            whole = super()._is_whole(picture, camera)
            stamps[self._numbers.number] = picture.camera_time, picture.identifier
            return whole

    lost: Counter[str] = Counter()
    found = replace(context("color", SIZE), lost=lambda kind, number: lost.update({kind: number}))
    wanted = {"Width": SIZE[0], "Height": SIZE[1]} if camera == "aravis" else {}
    with running(camera):
        word = "GV01" if (camera, backend) == ("aravis", "aravis") else "127.0.0.1"
        stage = Watched(found, camera=word, backend=backend, interface="127.0.0.1", features=wanted)
        frames = list(islice(stage.process(), count))
        stage.close()
        seen = [str(info) for info in discovered("aravis")] if camera == "aravis" else []
    print(
        json.dumps(
            {
                "numbers": [frame.header.seq for frame in frames],
                "captured": [frame.header.time for frame in frames],
                "stamps": [stamps[frame.header.seq] for frame in frames],
                "shape": frames[0].pixels.shape,
                "lost": lost,
                "seen": seen,
                "now": time.time_ns(),
            }
        )
    )


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
