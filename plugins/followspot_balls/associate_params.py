"""Parameters of the association of candidates with targets."""

from __future__ import annotations

from typing import Literal

from followspot import Field, StageParams


class AssociateParams(StageParams):
    """How balls and clutter show, and how evidence moves the existence of targets."""

    weighed: Literal["all", "poor"] = Field(
        "all",
        description="targets whose places are weighed: all, or tracked ones that fewer than three "
        "candidates show where they are expected; the candidates of others stay as they are",
    )
    detection: float = Field(
        0.6,
        gt=0,
        lt=1,
        unit="1",
        description="probability that a camera shows a ball that is there; lowering it suits crowds",
    )
    persistence: float = Field(
        0.85,
        ge=0,
        lt=1,
        unit="1",
        description="correlation over 1/30 s of whether a camera shows a ball; raising it forgives a "
        "view that stays empty, and doubts what turns up there",
    )
    clutter: float = Field(
        0.015,
        gt=0,
        unit="1",
        description="least number of false blobs in a square of a ball's radius; raising it asks for "
        "more views",
    )
    neighbourhood: float = Field(
        3.0,
        gt=1,
        unit="1",
        description="radius over the ball's in which other blobs count as false; raising it smooths "
        "their density",
    )
    blob_sigma: float = Field(
        0.8, gt=0, unit="px", description="sigma of a blob's centre; raising it suits bad calibrations"
    )
    relative_sigma: float = Field(
        0.12, ge=0, unit="1", description="what adds to it, over the ball's radius in the picture"
    )
    hidden_sigma: float = Field(
        0.6,
        ge=0,
        unit="1",
        description="what a covered outline adds to it, likewise; raising it trusts fragments less",
    )
    other_probability: float = Field(
        0.1,
        gt=0,
        unit="1",
        description="probability of paint, light or a reflector at a place, over that of a ball",
    )
    forecast_sigma: float = Field(
        0.01,
        gt=0,
        unit="m",
        description="sigma that adds to the forecast's; raising it trusts forecasts less",
    )
    jump_sigma: float = Field(
        0.1,
        gt=0,
        unit="m",
        description="the same for a target that jumps; raising it lets targets jump farther",
    )
    jump_probability: float = Field(
        0.02,
        gt=0,
        lt=1,
        unit="1",
        description="probability of a jump; raising it leaves wrong places sooner",
    )
    memory: float = Field(
        0.9,
        ge=0,
        lt=1,
        unit="1",
        description="share of the log-odds that 1/30 s keeps; raising it averages over more frames",
    )
    drift: float = Field(
        0.2,
        ge=0,
        unit="nats",
        description="what 1/30 s takes from the log-odds; raising it gives targets up sooner",
    )
    absence: float = Field(
        0.5,
        ge=0,
        unit="nats",
        description="what a frame without candidates takes besides; raising it forgets places sooner",
    )
    largest_odds: float = Field(
        8.0,
        gt=0,
        unit="nats",
        description="largest log-odds of a target; raising it keeps covered targets longer",
    )
    least_evidence: float = Field(
        -1.0,
        unit="nats",
        description="log-likelihood ratio of a frame below which it speaks against a tracked target; raising "
        "it prefers gaps to wrong places",
    )
    least_fit: float = Field(
        5.0,
        unit="nats",
        description="that of the views alone that show the target, below which such a frame leaves it no "
        "candidates; raising it prefers gaps to wrong places",
    )
    silence_odds: float = Field(
        -2.5,
        unit="nats",
        description="log-odds below which a tracked target is given up; raising it goes silent sooner",
    )
    confirmation_odds: float = Field(
        2.0,
        unit="nats",
        description="log-odds from which a lost target is found; raising it avoids false recoveries",
    )
    confirmation_margin: float = Field(
        3.0,
        ge=0,
        unit="nats",
        description="smallest lead over the next likely place; raising it waits longer",
    )
    reach: float = Field(
        0.15,
        gt=0,
        unit="m",
        description="largest step of a sought target between frames; raising it finds faster ones",
    )
