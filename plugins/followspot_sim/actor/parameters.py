"""The parameters of a simulated room with people, the same for its cameras and its ground truth."""

from __future__ import annotations

import pydantic

from followspot import Field, StageParams


class ActorParams(StageParams):
    """The people of the simulated room; equal parameters give equal rooms."""

    frames: int = Field(600, ge=0, unit="frames", description="length of the recording; 0: endless")
    fps: float = Field(15.0, ge=0.001, le=1000, unit="1/s", description="pictures of each camera per second")
    seed: int = Field(1, ge=0, unit="1", description="seed of the performance: people, ways and furniture")
    people: int = Field(
        2, ge=0, le=20, unit="1", description="number of people that walk, turn and look around"
    )
    room_size: tuple[float, float, float] = Field(
        (6.4, 6.0, 2.7),
        unit="m",
        description="width, depth and height of the room around the origin of the floor",
    )
    walking_area: tuple[float, float, float, float] = Field(
        (-1.8, -1.6, 1.8, 1.6), unit="m", description="part of the floor where people walk: x0, y0, x1, y1"
    )
    clear_radius: float = Field(
        0.0, ge=0, le=10, unit="m", description="distance that people keep from the middle of the floor"
    )
    cupboard: tuple[float, float] | None = Field(
        None,
        unit="m",
        description="position of a cupboard that people hide behind, as seen from the middle; none: no "
        "cupboard",
    )
    noise_sigma: float = Field(
        2.0, ge=0, le=20, unit="grey levels", description="standard deviation of the sensor noise"
    )
    dimmed: tuple[float, float, float] | None = Field(
        None,
        description="the lights are dimmed: from and to a time, s, and the share of light left; none: never",
    )
    realtime: bool = Field(
        False, description="whether frames come at the pace of fps instead of as fast as possible"
    )

    @pydantic.field_validator("dimmed")
    @classmethod
    def _check_light(cls, dimmed: tuple[float, float, float] | None) -> tuple[float, float, float] | None:
        if dimmed is not None and not (dimmed[0] <= dimmed[1] and 0 <= dimmed[2] <= 1):
            raise ValueError("dimmed must be two ascending times and a share of 0 to 1")
        return dimmed

    def light(self, time: float) -> float:
        """Share of the usual light at a time, s."""
        begin, end, share = self.dimmed or (0.0, 0.0, 1.0)
        return share if begin <= time < end else 1.0

    @pydantic.field_validator("room_size")
    @classmethod
    def _check_size(cls, size: tuple[float, float, float]) -> tuple[float, float, float]:
        if min(size) <= 0:
            raise ValueError("room_size must be three lengths above 0")
        return size

    @pydantic.field_validator("walking_area")
    @classmethod
    def _check_area(cls, area: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        if not (area[0] < area[2] and area[1] < area[3]):
            raise ValueError("walking_area must be x0, y0, x1, y1 with x0 < x1 and y0 < y1")
        return area
