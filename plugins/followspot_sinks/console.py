"""Tracks as lines of text."""

from __future__ import annotations

from followspot import Field, Stage, StageParams
from followspot.tracking import STATES, Tracks


class Console(Stage):
    """Print a line per target, some times per second of capture time."""

    class Params(StageParams):
        maximum_rate: float = Field(
            1.0, gt=0, le=1000, unit="1/s", description="largest number of frames printed per second"
        )

    params: Params

    def setup(self) -> None:
        """Print the first frame that comes."""
        self.names = tuple(self.room.targets)
        self.width = max(map(len, self.names), default=0)
        self.next = 0

    def process(self, tracks: Tracks) -> None:
        """Print one frame if the last print was long enough ago."""
        time = tracks.header.time
        if time < self.next:
            return
        self.next = time + round(1e9 / self.params.maximum_rate)
        for target, state, xyz, sigma in zip(
            tracks.target, tracks.state, tracks.xyz, tracks.sigma, strict=True
        ):
            x, y, z = xyz.tolist()
            print(
                f"{time / 1e9:9.3f} s  {self.names[target]:{self.width}}  {STATES[state]:9}  "
                f"{x:+7.3f} {y:+7.3f} {z:+7.3f} m  ± {1000 * sigma.max():.1f} mm",
                flush=True,
            )
