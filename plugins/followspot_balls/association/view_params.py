"""Parameters of the stages that weigh positions of targets by the blobs of all views."""

from __future__ import annotations

from followspot import Field, StageParams


class ViewParams(StageParams):
    """How views detect balls and clutter, and how evidence changes the existence of targets."""

    detection: float = Field(
        0.6,
        gt=0,
        lt=1,
        unit="1",
        description="probability that a camera detects a ball in its picture; lowering it suits crowds",
    )
    persistence: float = Field(
        0.85,
        ge=0,
        lt=1,
        unit="1",
        description="correlation of a camera's detections of a ball in successive frames (frames less than "
        "1/30 s apart count in proportion); raising it gives less weight to a view that goes on detecting "
        "nothing, and to a blob that then appears in it",
    )
    clutter: float = Field(
        0.015,
        gt=0,
        unit="1",
        description="smallest clutter density: number of false blobs in a square whose side is the radius of "
        "the ball's image, or 0.8 % of the picture's longer side if that is more; raising it requires more "
        "views",
    )
    neighbourhood: float = Field(
        3.0,
        gt=1,
        unit="1",
        description="radius around a ball in which other blobs count as clutter, over the ball's radius; "
        "raising it smooths the clutter density",
    )
    blob_sigma: float = Field(
        0.8, gt=0, unit="px", description="sigma of a blob's centre; raising it suits inexact calibrations"
    )
    relative_sigma: float = Field(
        0.12,
        ge=0,
        unit="1",
        description="sigma that adds to blob_sigma, over the ball's radius in the picture; raising it suits "
        "large images of balls",
    )
    hidden_sigma: float = Field(
        0.6,
        ge=0,
        unit="1",
        description="sigma that a completely covered outline adds, over the ball's radius in the picture; "
        "raising it trusts fragments less",
    )
    other_probability: float = Field(
        0.1,
        gt=0,
        unit="1",
        description="prior probability of paint, light or a reflector at a position, over that of a ball; "
        "raising it requires more evidence from both kinds of cameras",
    )
    forecast_sigma: float = Field(
        0.01,
        gt=0,
        unit="m",
        description="sigma that adds to that of the forecast; raising it trusts forecasts less",
    )
    jump_sigma: float = Field(
        0.1,
        gt=0,
        unit="m",
        description="sigma that adds to that of the forecast if the target jumps; raising it allows longer "
        "jumps",
    )
    jump_probability: float = Field(
        0.02,
        gt=0,
        lt=1,
        unit="1",
        description="prior probability of a jump between frames; raising it leaves wrong positions sooner",
    )
    memory: float = Field(
        0.9,
        ge=0,
        lt=1,
        unit="1",
        description="share of the log-odds of existence that remains after a frame (while a target is "
        "tracked, frames less than 1/30 s apart count in proportion); raising it averages over more frames",
    )
    drift: float = Field(
        0.2,
        ge=0,
        unit="nats",
        description="decrease of the log-odds of existence in each frame (while a target is tracked, frames "
        "less than 1/30 s apart count in proportion); raising it ends targets sooner",
    )
    largest_odds: float = Field(
        8.0,
        gt=0,
        unit="nats",
        description="largest log-odds of existence; raising it keeps covered targets longer",
    )
    silence_odds: float = Field(
        -2.5,
        unit="nats",
        description="log-odds of existence below which a track ends; raising it ends tracks sooner",
    )
    reach: float = Field(
        0.15,
        gt=0,
        unit="m",
        description="largest step of a target without a track between frames; raising it finds faster "
        "targets",
    )
