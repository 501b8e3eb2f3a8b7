"""Stage `lsl.outlet`: where targets are, as a stream of the Lab Streaming Layer."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from followspot import Array, Field, Stage
from followspot.tracking import LOST, Tracks
from followspot_lsl.library import LslParams, load, wall_clock_offset

CHANNELS = (
    ("state", "1"),
    *((axis, "m") for axis in "xyz"),
    *((f"v{axis}", "m/s") for axis in "xyz"),
)
"""Name and unit of each channel of a target."""


class Outlet(Stage):
    """Send each frame's targets as one sample: state, position and velocity of each target of the room.

    Channels are called `red.state`, `red.x`, ... and say their unit. The state is that of tracks: 0 lost,
    1 tracked, 2 missing, 3 predicted; position and velocity of a target that is not there are NaN.
    """

    class Params(LslParams):
        """The stream, and its times."""

        name: str = Field("followspot", pattern=r"^[\w .:-]{1,100}$", description="name of the stream")
        times: Literal["capture", "sending"] = Field(
            "capture",
            description="time of a sample: when the cameras took it, or when it is sent; recordings and "
            "simulated rooms have other clocks than this host: take sending for them",
        )

    params: Params

    def setup(self) -> None:
        """Open the stream. Raises InputError, FollowspotError."""
        self.pylsl = load(self.params)
        info = self.pylsl.StreamInfo(
            self.params.name,
            "MoCap",
            max(1, len(CHANNELS) * len(self.room.targets)),
            self.pylsl.IRREGULAR_RATE,
            self.pylsl.cf_double64,
            f"followspot {self.context.name}",
        )
        described = info.desc().append_child("channels")
        for target in self.room.targets:
            for name, unit in CHANNELS:
                channel = described.append_child("channel")
                channel.append_child_value("label", f"{target}.{name}")
                channel.append_child_value("unit", unit)
        self.outlet: Any = self.pylsl.StreamOutlet(info)

    def process(self, tracks: Tracks) -> None:
        """Send one frame."""
        sample = sample_of(tracks, max(1, len(self.room.targets)))
        if self.params.times == "sending":
            self.outlet.push_sample(sample)
        else:
            stamp = (tracks.header.time - wall_clock_offset(self.pylsl)) / 1e9
            self.outlet.push_sample(sample, stamp)

    def close(self) -> None:
        """Close the stream."""
        self.outlet = None


def sample_of(tracks: Tracks, targets: int) -> list[float]:
    """The values of one sample, target by target in the order of `CHANNELS`; targets: of the room."""
    values: Array = np.full((targets, len(CHANNELS)), np.nan)
    values[:, 0] = LOST
    known = tracks.target < targets
    values[tracks.target[known]] = np.column_stack([tracks.state, tracks.xyz, tracks.velocity])[known]
    flat: list[float] = values.ravel().tolist()
    return flat
