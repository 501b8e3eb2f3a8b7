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
"""Colours of balls in a colour camera, RGB, by the name of the target."""


class SimParams(StageParams):
    """The performance in the simulated room; equal parameters give equal rooms."""

    frames: int = Field(600, ge=0, unit="frames", description="length of the recording; 0: endless")
    fps: float = Field(60.0, ge=0.001, le=1000, unit="1/s", description="pictures of each camera per second")
    seed: int = Field(
        1, ge=0, unit="1", description="seed of the performance; another seed gives another one"
    )
    people: int = Field(
        2, ge=0, le=6, unit="1", description="number of people that carry, throw and hide the balls"
    )
    projections: int = Field(
        4, ge=0, le=12, unit="1", description="number of projected spots per ball; 0: dark"
    )
    projection_brightness: float = Field(
        0.6, ge=0, le=1, unit="1", description="brightness of projected light over that of the balls"
    )
    noise_sigma: float = Field(
        1.0, ge=0, le=20, unit="grey levels", description="standard deviation of the sensor noise"
    )
    hide_balls: bool = Field(True, description="whether people put balls into their bags for a while")
    cover_balls: bool = Field(
        False,
        description="whether people hold balls against their bodies, and wear reflectors and patches in the "
        "colours of the balls",
    )
    only_target: str = Field(
        "",
        description="the only target to show, without people and projections, to learn its template; empty: "
        "all",
    )
    realtime: bool = Field(
        False, description="whether frames come at the pace of fps instead of as fast as possible"
    )
    colors: dict[str, Colour] = Field({}, description="RGB of targets, 0 to 255, instead of the usual ones")

    def color(self, target: str, number: int) -> Colour:
        """RGB of a target; a target of unknown name takes the `number`-th usual colour."""
        known = {**COLORS, **self.colors}
        return known.get(target) or list(COLORS.values())[number % len(COLORS)]


class CameraParams(SimParams):
    """The performance in the simulated room, and the clock of this camera."""

    clock_offset: float = Field(
        0.0,
        ge=-1,
        le=1,
        unit="s",
        description="delay of this camera's pictures after their time stamps, unknown to the room",
    )


class DepthCameraParams(CameraParams):
    """The performance, the clock of the camera, and its errors; the defaults are those of a time-of-flight
    camera.
    """

    depth_sigma: float = Field(
        0.002, ge=0, le=1, unit="m", description="standard deviation of a depth near the camera"
    )
    depth_sigma_growth: float = Field(
        0.0004,
        ge=0,
        le=1,
        unit="1/m",
        description="growth of a depth's standard deviation with the square of the depth, as light falls off",
    )
    hole_share: float = Field(
        0.005, ge=0, le=1, unit="1", description="share of the pixels that measure nothing, anywhere"
    )
    edge_hole_share: float = Field(
        0.5,
        ge=0,
        le=1,
        unit="1",
        description="share of the pixels at a step of the depth that measure nothing",
    )
    edge_step: float = Field(
        0.1, gt=0, unit="m", description="smallest step of the depth between neighbours that is an edge"
    )
    maximum_depth: float = Field(8.0, gt=0, unit="m", description="largest depth that is measured")
