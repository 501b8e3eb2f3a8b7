"""The parameters of a simulated room, the same for its cameras and its ground truth, and of a camera."""

from __future__ import annotations

from followspot import Field, StageParams

Colour = tuple[int, int, int]

COLORS: dict[str, Colour] = {
    "green": (40, 255, 60),
    "red": (255, 65, 40),
    "blue": (45, 90, 255),
    "yellow": (255, 225, 25),
    "magenta": (255, 60, 220),
    "cyan": (50, 235, 255),
}
"""What a colour camera sees of a ball, RGB, by the name of the target."""


class SimParams(StageParams):
    """What happens in the simulated room; equal parameters give equal rooms."""

    frames: int = Field(600, ge=0, description="length of the recording; 0 never ends", unit="frame")
    fps: float = Field(60.0, ge=0.001, le=1000, description="pictures of each camera per second", unit="1/s")
    seed: int = Field(1, ge=0, description="another seed, another performance", unit="1")
    people: int = Field(2, ge=0, le=6, description="who carry, throw and hide the balls", unit="1")
    projections: int = Field(4, ge=0, le=12, description="projected spots for each ball; 0: dark", unit="1")
    projection_brightness: float = Field(
        0.6, ge=0, le=1, description="projected light over that of the balls", unit="1"
    )
    noise: float = Field(
        1.0, ge=0, le=20, description="standard deviation of sensor noise", unit="grey level"
    )
    hide: bool = Field(True, description="people put balls into their bags for a while")
    alone: str = Field("", description="show this target only: no people, no projections (for templates)")
    realtime: bool = Field(False, description="deliver at the pace of fps instead of as fast as wanted")
    colors: dict[str, Colour] = Field({}, description="RGB of targets, 0 to 255, instead of the usual ones")

    def color(self, target: str, number: int) -> Colour:
        """RGB of a target; a target of unknown name takes the `number`-th usual colour."""
        known = {**COLORS, **self.colors}
        return known.get(target) or list(COLORS.values())[number % len(COLORS)]


class CameraParams(SimParams):
    """What happens in the simulated room, and when this camera looks."""

    clock_offset: float = Field(
        0.0,
        ge=-1,
        le=1,
        unit="s",
        description="how much later than its time stamps say this camera takes its pictures, which nobody "
        "tells the room",
    )
