"""Stage `balls.smooth`: smooths tracks by later positions, and by positions that came late."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from followspot import Field, Lagged, Stage, Window, at
from followspot.tracking import Positions, Tracks
from followspot_balls.filtering.motion import Motion
from followspot_balls.smooth.smoother import Filtered, MotionParameters, filtered, nothing, smoothed
from followspot_balls.smooth.step import Step, insert, observation, of_room
from followspot_target_filter.manoeuvre import ManoeuvreParams


class Smooth(Stage):
    """Smooth tracks by the positions before and after them, some frames late or at the end of the input.

    A target has a row in the same frames, and with the same state, as in the tracker's output. Positions that
    come late over a bad link are used if they agree with the motion and their frame has not been sent.
    Several fusions may send positions.
    """

    class Params(ManoeuvreParams):
        """The motion model and the lag."""

        lag_frames: int = Field(
            6,
            ge=0,
            unit="frames",
            description="number of later frames for which a frame waits; 0: all frames are sent at the end "
            "of the input, for recordings; raising it smooths more and waits longer for late positions",
        )
        measurement_sigma: float = Field(
            0.008,
            gt=0,
            unit="m",
            description="sigma of a position without a covariance; raising it smooths more",
        )
        minimum_support: int = Field(
            3,
            ge=1,
            unit="1",
            description="candidates that may show a bounce; raising it smooths more",
        )

    params: Params

    def setup(self) -> None:
        """Begin without a past."""
        p = self.params
        self.motion = MotionParameters(p.acceleration_sigma, p.bounces)
        self.before = nothing(len(self.room.targets))
        self.steps: list[Step] = []
        self.passed: list[Filtered] = []
        self.newest = self.sent = -1
        self.punctual = True

    def process(self, tracks: Tracks, positions: Window[Positions]) -> Lagged[Tracks]:
        if tracks.header.time <= self.newest:
            return ()
        for message in positions:
            self.observe(message)
        self.newest = tracks.header.time
        self.insert(Step(tracks.header.time, tracks.header.seq, tracks))
        return tuple(self.due())

    def remaining(self) -> Iterator[Tracks]:
        """All frames that have not been sent."""
        if self.steps:
            yield from self.frames(len(self.steps))

    def observe(self, positions: Positions) -> None:
        """Note positions, unless their frame was sent."""
        time, p = positions.header.time, self.params
        if time > self.sent:
            late = time <= self.newest
            seen = observation(
                positions, len(self.before.alive), p.measurement_sigma, p.minimum_support, late=late
            )
            self.insert(Step(time, observed=(seen,)))
        elif self.punctual:
            self.punctual = False
            self.context.warn(f"positions came more than {p.lag_frames} frames late and were left out")

    def insert(self, step: Step) -> None:
        """Add the tracks or positions of a time; filtered results from there on are discarded."""
        del self.passed[insert(self.steps, step) :]

    def due(self) -> Iterator[Tracks]:
        """The frames that are older than the lag."""
        lag = self.params.lag_frames
        if lag:
            framed = [number for number, step in enumerate(self.steps) if step.tracks is not None]
            if len(framed) > lag:
                yield from self.frames(framed[-lag - 1] + 1)

    def frames(self, count: int) -> Iterator[Tracks]:
        """Smooth all steps and send the first `count` of them."""
        for step in self.steps[len(self.passed) :]:
            past = self.passed[-1] if self.passed else self.before
            self.passed.append(filtered(past, step, self.motion))
        motions = smoothed(self.passed, self.motion.acceleration)
        sent, self.steps = self.steps[:count], self.steps[count:]
        forward, self.passed = self.passed[:count], self.passed[count:]
        self.before, self.sent = forward[-1], sent[-1].time
        for step, past, motion in zip(sent, forward, motions, strict=False):
            if step.tracks is not None:
                yield at(step.time, with_motion(step.tracks, past.motion, motion), seq=step.seq)

    def state(self) -> Any:
        before = self.before._asdict()
        return {
            **before,
            "prior": before["prior"]._asdict(),
            "motion": before["motion"]._asdict(),
            "steps": [step.to_data() for step in self.steps],
            "newest": self.newest,
            "sent": self.sent,
        }

    def restore(self, state: Any) -> None:
        prior, motion = (
            Motion(*(np.array(state[which][name]) for name in Motion._fields))
            for which in ("prior", "motion")
        )
        alive, reported, linked = (np.array(state[name]) for name in ("alive", "reported", "linked"))
        self.before = Filtered(int(state["time"]), prior, motion, alive, reported, linked)
        self.steps, self.passed = [Step.from_data(data) for data in state["steps"]], []
        self.newest, self.sent = int(state["newest"]), int(state["sent"])


def with_motion(tracks: Tracks, past: Motion, motion: Motion) -> Tracks:
    """The tracks with the places and velocities of a motion; rows of unknown targets stay as they are.

    Variance that the tracker states beyond that of the forward filter stays: it is of what no later position
    tells, such as that the track may have left its target.
    past: from the observations until then.
    """
    rows = of_room(tracks, len(motion.state))
    target = tracks.target[rows]
    xyz, velocity, sigma = tracks.xyz.copy(), tracks.velocity.copy(), tracks.sigma.copy()
    beyond = np.maximum(sigma[rows] ** 2 - past.sigma[target] ** 2, 0.0)
    xyz[rows], velocity[rows] = motion.xyz[target], motion.velocity[target]
    sigma[rows] = np.sqrt(motion.sigma[target] ** 2 + beyond)
    return Tracks(target=tracks.target, state=tracks.state, xyz=xyz, velocity=velocity, sigma=sigma)
