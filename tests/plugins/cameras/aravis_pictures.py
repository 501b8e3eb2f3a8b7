"""Aravis' cameras on 127.0.0.1, 127.0.0.2, ..., which show pictures by the moment of their trigger.

python aravis_pictures.py PICTURES.npy RATE: PICTURES (C, F, H, W, 3) uint8 RGB; camera n shows at the k-th
period since 1970 picture k, forth and back. Prints a line when all run, and ends when its input ends.
Introspection frees the callback of set_fill_pattern at once, so it is set by a call of the library.
"""

from __future__ import annotations

import ctypes
import sys
import time

import numpy as np

FILL = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32
)


def shown(moment: int, count: int) -> int:
    """Number of the picture at a moment."""
    turn = moment % (2 * count - 2)
    return min(turn, 2 * count - 2 - turn)


def main(path: str, rate: float) -> None:
    """Run the cameras."""
    import gi

    gi.require_version("Aravis", "0.8")
    from gi.repository import Aravis

    library = ctypes.CDLL("libaravis-0.8.so.0")
    library.arv_buffer_get_data.restype = ctypes.c_void_p
    library.arv_buffer_get_data.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    library.arv_fake_camera_set_fill_pattern.argtypes = [ctypes.c_void_p, FILL, ctypes.c_void_p]

    def filler(pictures):
        def fill(buffer, data, exposure, gain, form):
            size = ctypes.c_size_t()
            memory = library.arv_buffer_get_data(buffer, ctypes.byref(size))
            picture = np.ascontiguousarray(pictures[shown(int(time.time() * rate), len(pictures))])
            ctypes.memmove(memory, picture.ctypes.data, picture.nbytes)

        return FILL(fill)

    kept = []
    for number, pictures in enumerate(np.load(path, mmap_mode="r")):
        server = Aravis.GvFakeCamera.new(f"127.0.0.{number + 1}", f"GV{number + 1:02}")
        camera, fill = server.get_fake_camera(), filler(pictures)
        library.arv_fake_camera_set_fill_pattern(hash(camera), fill, None)
        kept.append((server, camera, fill))
    print("running" if all(server.is_running() for server, *_ in kept) else "not running", flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
