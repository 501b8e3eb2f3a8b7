"""Any port into the Rerun viewer, or into a file for it; needs the extra `rerun`."""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from followspot import Field, Message, Mistake, OutputHost, OutputPath, Room, Stage, StageParams
from followspot.errors import FollowspotError
from followspot.files import unused_path
from followspot.operating_system.requirements import is_importable
from followspot.room import Member
from followspot_sinks.line_sink import below
from followspot_sinks.rerun.layout import layout_of
from followspot_sinks.rerun.scene import entity_of, log_cameras, parts_of, shape_of

APPLICATION = "followspot"
TIMELINE = "capture"
REMEDY = 'pip install "followspot[rerun]"'


class Rerun(Stage):
    """Show pictures, blobs, points, tracks and poses in the Rerun viewer, with the room's cameras.

    Tracks have an ellipsoid of three sigma, and their axes if their orientation is known; skeletons have
    bones.

    The viewer opens with the room beside the pictures of its cameras.

    Use one sink per port. Sinks with the same viewer share a recording there; each file is a recording of its
    own: open several together.
    """

    class Params(StageParams):
        path: OutputPath = Field("show.rrd", description="the file, below the output folder")
        viewer: OutputHost = Field(
            "", description="address of a running viewer, rerun+http://HOST:PORT/proxy, instead of a file"
        )
        name: str = Field("", description="name in the viewer; by default this stage's name")

    params: Params
    stream: Any = None
    path: Path | None = None
    """The file, None with a viewer."""

    @classmethod
    def check_files(cls, params: Any, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Warn if this host lacks rerun-sdk; that of the stage may have it."""
        if is_importable("rerun"):
            return ()
        return [Mistake(None, "rerun-sdk is not installed", REMEDY, warning=True)]

    def setup(self) -> None:
        """Open the file or connect. Raises FollowspotError if rerun-sdk is missing."""
        try:
            self.rerun = importlib.import_module("rerun")
        except ImportError as error:
            raise FollowspotError(f"sinks.rerun needs rerun-sdk: {error}\n    {REMEDY}") from None
        run = str(self.context.out.absolute())
        self.stream = self.rerun.RecordingStream(APPLICATION, recording_id=run)
        if self.params.viewer:
            self.stream.connect_grpc(self.params.viewer)
        else:
            path = below(self.context.out, self.params.path)
            path.parent.mkdir(parents=True, exist_ok=True)
            self.path = unused_path(path) if self.context.resumed else path
            self.stream.save(self.path)
        blueprint = importlib.import_module("rerun.blueprint")
        self.stream.send_blueprint(layout_of(blueprint, self.room))
        log_cameras(self.rerun, self.stream, self.room)
        self.shown = True

    def process(self, message: Message) -> None:
        """Log the message at its capture time; warn once of a type that the viewer cannot show.

        Raises FollowspotError if the file was removed.
        """
        if self.stream is None:
            raise FollowspotError(f"{self.context.name} has no stream: it was not set up")
        self._require_file()
        shape = shape_of(self.rerun, message, self.room)
        if shape is not None:
            self.stream.set_time(TIMELINE, duration=message.header.time / 1e9)
            entity = entity_of(message, self.params.name or self.context.name)
            self.stream.log(entity, shape)
            for name, part in parts_of(self.rerun, message).items():
                self.stream.log(f"{entity}/{name}", part)
        elif self.shown:
            self.shown = False
            self.context.warn(f"Rerun shows nothing like {type(message).__name__}")

    def close(self) -> None:
        """Write the remaining data. Raises FollowspotError if the file was removed."""
        if self.stream is not None:
            stream, self.stream = self.stream, None
            stream.flush()
            stream.disconnect()
            self._require_file()

    def _require_file(self) -> None:
        """Raises FollowspotError if the file is gone: the SDK does not tell."""
        if self.path is not None and not self.path.exists():
            raise FollowspotError(f"{self.path} was moved or removed while the run wrote it")
