"""Stages for tools/soak.py: live cameras of the simulated room, and who judges what is tracked."""

from __future__ import annotations

import math
import os
import threading
import time

import numpy as np

from followspot import Field, OutputPath, Source, Stage, at
from followspot.tracking import TRACKED, Frame, Tracks
from followspot_sim.camera import SimCamera
from followspot_sim.parameters import CameraParams, SimParams
from followspot_sim.truth import SimTruth


class LiveCamera(SimCamera):
    """A camera that looks into a room where time goes on: one that comes back sees what the others see."""

    live = True

    class Params(CameraParams):
        """The room, and since when it is open."""

        opened: float = Field(0.0, ge=0, description="time of frame 0 by the monotonic clock", unit="s")

    params: Params  # type: ignore[assignment]  # those of the base, and more

    def setup(self) -> None:
        """Prepare the room."""
        super().setup()
        self.over = threading.Event()

    def close(self) -> None:
        """End the waiting."""
        self.over.set()

    def process(self) -> Source[Frame]:
        """Each picture at its time by the clock of this host; those after the last are never taken."""
        opened, fps = self.params.opened, self.params.fps
        frame = math.ceil((time.monotonic() - opened) * fps)
        while not (self.params.frames and frame >= self.params.frames):
            due = opened + frame / fps
            if self.over.wait(max(0.0, due - time.monotonic())):
                return
            captured = time.time_ns() - round((time.monotonic() - due) * 1e9)
            pixels = self.context.loan(self._picture.shape, "u1")
            self._picture.render(frame, pixels)
            yield at(captured, Frame(camera=self.camera.name, pixels=pixels), seq=frame)
            frame = max(frame + 1, math.floor((time.monotonic() - opened) * fps))


class Judge(Stage):
    """Writes for each frame when it was tracked, s of the monotonic clock, and how well, m.

    That is the largest error of the targets that a colour and an infrared camera see; infinite where one of
    them is not tracked. A full disk is an error each time.
    """

    class Params(SimParams):
        """The room that the cameras look into."""

        path: OutputPath = Field("judged.csv", description="file to write")

    params: Params

    def setup(self) -> None:
        """Open the file, behind what was written before."""
        self.truth = SimTruth(self.context, **self.params.model_dump(exclude={"path"}))
        self.truth.setup()
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        self.file = os.open(self.context.out / self.params.path, flags, 0o600)

    def close(self) -> None:
        """Close the file."""
        os.close(self.file)

    def process(self, tracks: Tracks) -> None:
        """One line."""
        frame = tracks.header.seq
        line = f"\n{time.monotonic():.4f},{frame},{self.error(tracks):.4f}"  # first the end of a cut one
        os.write(self.file, line.encode())

    def error(self, tracks: Tracks) -> float:
        """The largest, m; 0 where no target is to be seen."""
        truth = self.truth.truth(tracks.header.seq)
        names = list(self.room.targets)
        placed = np.full((len(names), 3), np.inf)
        found = tracks.state == TRACKED
        placed[tracks.target[found]] = tracks.xyz[found]
        wanted = [names.index(name) for name in truth.objects]
        errors = np.linalg.norm(placed[wanted] - truth.xyz, axis=1)
        return float(errors[truth.pair].max(initial=0.0))
