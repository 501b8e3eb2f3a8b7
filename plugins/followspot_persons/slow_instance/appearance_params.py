"""Parameters of `persons.appearance`."""

from __future__ import annotations

from followspot import Field, InputPath, StageParams
from followspot_persons.body.shape import SHIPPED as SHIPPED_SHAPE
from followspot_persons.color.difference import SHIPPED as SHIPPED_RELATIONS


class AppearanceParams(StageParams):
    """Finding, learning and remembering persons."""

    shape: InputPath = Field(SHIPPED_SHAPE, description="shape model of head and upper body")
    color_relations: InputPath = Field(SHIPPED_RELATIONS, description="how the colours of features relate")
    particles: int = Field(
        200,
        ge=20,
        le=10_000,
        unit="1",
        description="particles per person; raising it improves poses and costs time",
    )
    minimum_score: float = Field(
        0.8,
        unit="1",
        description="smallest score of a box that initiates a person; raising it avoids mistakes",
    )
    confirmation_score: float = Field(
        4.0, unit="1", description="sum of scores that confirms a person; raising it avoids false persons"
    )
    real_valued_boxes: bool = Field(
        False, description="whether the weight of a box grows with the certainty of its score"
    )
    walkable: tuple[tuple[float, float], ...] = Field(
        (),
        unit="m",
        description="corners x, y of the part of the floor where people can be, taken as convex; none: "
        "everywhere",
    )
    maximum_missed_time: float = Field(
        1.5,
        gt=0,
        unit="s",
        description="time without a box until a person is absent; raising it bridges more",
    )
    maximum_unboxed_time: float = Field(
        8.0,
        ge=0,
        unit="s",
        description="time for which the foreground alone prolongs a person without boxes; raising it bridges "
        "more",
    )
    foreground_boxes: bool = Field(
        True,
        description="whether a region that differs from the background and is as high and as broad as a "
        "standing person counts as a weak box of the detector; false if other things than people move in "
        "the room",
    )
    memory_time: float = Field(
        120.0,
        gt=0,
        unit="s",
        description="time for which an absent person is remembered; raising it recognises persons after "
        "longer absences, but takes more other people for them",
    )
    specific_beats_generic: bool = Field(
        False,
        description="whether a box is another person's if its colours fit people in general better than "
        "the known person",
    )
    predict_colors: bool = Field(True, description="whether to predict the colours of unseen sides")
    color_averaging_frames: float = Field(
        30.0,
        ge=1,
        unit="frames",
        description="pictures that colours are averaged over; raising it adapts more slowly",
    )
    minimum_likeness: float = Field(
        -0.5,
        unit="1",
        description="smallest log-likelihood ratio with which a returning person is recognised; raising it "
        "recognises fewer returns",
    )
