"""One picture from every camera of a room, by the source that the room declares for it.

All are asked at once, as in a run: cameras that share a cable may do one by one what they cannot do together.
"""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from followspot.errors import FollowspotError, InputError
from followspot.graph.parameters import path_parameters
from followspot.plugins.registry import PluginError, load_stage
from followspot.room import Camera, Room
from followspot.room_file import load
from followspot.stage import Context, Stage
from followspot.stage_params import PathIn
from followspot.tracking import DepthImage, Frame
from followspot_doctor.finding import Finding, fine, wrong

MOST = 32
"""Cameras that are asked at once."""
TIMEOUT = 6.0
"""Seconds that a camera has to deliver its first picture."""


def cameras(path: str) -> Iterator[Finding]:
    """A finding a camera."""
    try:
        room = load(path)
    except InputError as error:
        for mistake in error.mistakes:
            yield wrong(f"room {mistake.place or path}", mistake.text, mistake.remedy)
        return
    with ThreadPoolExecutor(MOST) as pool:
        yield from pool.map(lambda camera: _camera(camera, room), room.cameras.values())


def _camera(camera: Camera, room: Room) -> Finding:
    if camera.host:
        return fine(camera.name, f"is on {camera.host}: run followspot doctor there")
    use = camera.source
    if use is None:
        return wrong(camera.name, "has no source", "source: {uses: cameras.video, with: {path: ...}}")
    try:
        stage = load_stage(use.uses)
        params = dict(use.params)
        for name in path_parameters(stage.Params, PathIn):
            if name in params:
                params[name] = str(Path(use.folder) / str(params[name]))
                if not Path(params[name]).exists():
                    return wrong(
                        camera.name, f"{params[name]} does not exist", "mend the path in the room file"
                    )
        with tempfile.TemporaryDirectory() as out:
            warnings: list[str] = []
            context = Context.serving(camera, room, name=camera.name, out=Path(out), warn=warnings.append)
            frame = _first(stage(context, **params))
    except PluginError as error:
        return wrong(camera.name, error.problem, str(error.remedy))
    except FollowspotError as error:
        return wrong(camera.name, " ".join(str(error).split()), "see the message")
    except Exception as error:
        text = " ".join(f"{use.uses}: {type(error).__name__}: {error}".split())
        return wrong(camera.name, text[:300], "mend its source in the room file")
    if not isinstance(frame, Frame | DepthImage):
        said = "; ".join(dict.fromkeys(warnings)) or ", ".join(f"{k} {v}" for k, v in use.params.items())
        text = f"{use.uses} gave no picture within {TIMEOUT:.0f} s: {said}"
        return wrong(camera.name, text, "is it connected, switched on, and free of other programs?")
    return _judged(camera, frame, use.uses)


def _judged(camera: Camera, frame: Frame | DepthImage, uses: str) -> Finding:
    picture = frame.depth if isinstance(frame, DepthImage) else frame.pixels
    height, width = picture.shape[:2]
    if (width, height) != camera.size:
        calibrated = "x".join(map(str, camera.size))
        text = f"sends {width}x{height}, calibrated for {calibrated}"
        return wrong(camera.name, text, "set its size, or calibrate it again at this one")
    if isinstance(frame, DepthImage):
        measured = f"{(picture > 0).mean():.0%} of the pixels measured"
        return fine(camera.name, f"{uses}: {width}x{height}, {measured}")
    if picture.shape[2] == 1 and camera.kind == "color":
        return wrong(camera.name, "sends grey pictures and is a colour camera", "kind: infrared?")
    return fine(camera.name, f"{uses}: {width}x{height}, mean grey {picture.mean():.0f}")


def _first(source: Stage) -> Any:
    """The first message, the error of the stage, or None after a while; the stage is closed either way."""
    result: list[Any] = []

    def take() -> None:
        try:
            source.setup()
            stream = source.process()
            result.append(next(stream, None))
            stream.close()
        except Exception as error:
            result.append(error)

    thread = threading.Thread(target=take, daemon=True)
    thread.start()
    thread.join(TIMEOUT)
    if not thread.is_alive():
        source.close()
    found = result[0] if result else None
    if isinstance(found, Exception):
        raise found
    return found
