"""Parameters of the association of people over cameras."""

from __future__ import annotations

from followspot import Field, StageParams


class AssociateParams(StageParams):
    """Errors of what was found, and when a person exists."""

    point_sigma: float = Field(
        2.0, gt=0, unit="px", description="sigma of a joint in a picture; raising it tolerates bad cameras"
    )
    body_sigma: float = Field(
        0.03,
        ge=0,
        unit="m",
        description="sigma of a joint on a body, in addition; raising it tolerates careless networks, and "
        "smooths more",
    )
    delay_sigma: float = Field(
        0.01,
        ge=0,
        unit="s",
        description="sigma of the times of exposure; raising it tolerates cameras out of step",
    )
    minimum_score: float = Field(
        0.1,
        unit="1",
        description="score below which joints and boxes are left out; raising it avoids mistakes",
    )
    overlap: float = Field(
        0.6,
        gt=0,
        le=1,
        unit="1",
        description="intersection over union from which two boxes of a picture are one person's; raising it "
        "separates people who stand close together, but also keeps two boxes of one person",
    )
    detection_probability: float = Field(
        0.9,
        gt=0,
        lt=1,
        unit="1",
        description="probability that a person in full view is found; raising it ends people sooner that "
        "cameras do not see",
    )
    confirmation_probability: float = Field(
        0.99,
        gt=0.5,
        lt=1,
        unit="1",
        description="probability of existence from which a person is reported; raising it avoids false "
        "persons, and reports later",
    )
    maximum_missed_time: float = Field(
        1.0,
        gt=0,
        unit="s",
        description="time without a detection after which a person is deleted; raising it bridges longer "
        "gaps, and keeps false persons longer",
    )
    recall_time: float = Field(
        1.0,
        ge=0,
        unit="s",
        description="time after the deletion of a person in which somebody found near gets the same number; "
        "raising it keeps numbers over longer gaps, but gives them to other people more often",
    )
    maximum_sigma: float = Field(
        0.25,
        gt=0,
        unit="m",
        description="sigma beyond which a joint is left out of skeleton and pose; raising it gives more "
        "joints, also inexact ones",
    )
    area: tuple[float, float, float, float] | None = Field(
        None, unit="m", description="part of the floor where people are sought: x0, y0, x1, y1; none: all"
    )
