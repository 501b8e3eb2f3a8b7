"""A stage of a few lines that drops kinds of pairs, to see what each kind is worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Field, Stage, StageParams
from followspot.tracking import Pairs


class Choose(Stage):
    """Keep pairs by the kinds of their two cameras."""

    class Params(StageParams):
        color_color: bool = Field(True, description="keep pairs of two colour cameras")
        color_infrared: bool = Field(True, description="keep pairs of a colour and an infrared camera")
        infrared_infrared: bool = Field(True, description="keep pairs of two infrared cameras: unlabelled")
        evident: bool = Field(
            False, description="every pair that is kept may recover a lost target, not only colour-infrared"
        )

    params: Params

    def process(self, pairs: Pairs) -> Pairs:
        p = self.params
        kept = pairs.where(
            (pairs.labelled & ~pairs.confirmed & p.color_color)
            | (pairs.confirmed & p.color_infrared)
            | (~pairs.labelled & p.infrared_infrared)
        )
        every = np.ones(len(kept.xy), bool)
        return replace(kept, confirmed=every, evident=every) if p.evident else kept
