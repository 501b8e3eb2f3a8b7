"""Parameters of filters of targets."""

from __future__ import annotations

from followspot.stage_params import Field, StageParams


class TargetFilterParams(StageParams):
    """The life cycle of targets: when they are confirmed, coasted, doubted and lost."""

    measurement_sigma: float = Field(
        0.008,
        gt=0,
        unit="m",
        description="sigma of a position without a covariance; raising it smooths more",
    )
    maximum_missed_frames: int = Field(
        25,
        ge=0,
        unit="frames",
        description="frames without measurement until a target is lost; raising it bridges more",
    )
    local_search_frames: int = Field(
        4,
        ge=0,
        unit="frames",
        description="frames without measurement in which a target is sought near its last position only, "
        "before it is sought everywhere in every second frame; raising it finds targets later that "
        "reappear elsewhere",
    )
    maximum_predicted_sigma: float = Field(
        0.1,
        gt=0,
        unit="m",
        description="sigma beyond which a target in one view is missing; raising it bridges longer gaps",
    )
    minimum_support: int = Field(
        3,
        ge=1,
        unit="1",
        description="candidates that confirm a target or a bounce at once, two if one of them is evident; "
        "raising it avoids mistakes",
    )
    confirmation_frames: int = Field(
        3,
        ge=1,
        unit="frames",
        description="evident frames that confirm a tentative target; raising it avoids mistakes",
    )
    confirmation_distance: float = Field(
        0.3,
        gt=0,
        unit="m",
        description="largest step of a tentative target between evident frames; a target whose position has "
        "a larger sigma needs twice as many of these; raising it confirms faster targets, and vague ones",
    )
    return_distance: float = Field(
        0.1,
        ge=0,
        unit="m",
        description="distance from its last measured position within which one candidate confirms a missing "
        "target, if the target had at least as many measurements as it may miss frames; 0: never; raising it "
        "finds covered targets sooner, and takes other things for them",
    )
    doubt_frames: int = Field(
        8,
        ge=0,
        unit="frames",
        description="after so many frames in a row in which fewer candidates than minimum_support show a "
        "tracked target, it is also sought everywhere in every fifth frame, if three cameras have it in "
        "their pictures and one of them sees colours; 0: never; raising it keeps tracks longer that have "
        "left their targets",
    )
    fade_time: float = Field(
        0.1,
        ge=0,
        unit="s",
        description="decay time of a coasting target's velocity; 0: a missing target stops at once",
    )
    marks: dict[str, tuple[float, float, float]] = Field(
        {},
        unit="m",
        description="positions by target: a lost target is found there, unless all others are tracked; "
        "tells targets apart where no camera sees colours",
    )
