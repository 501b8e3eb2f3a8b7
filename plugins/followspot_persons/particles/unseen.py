"""How the uncertainty of a person's place grows while the picture does not tell it.

The person walks on as in `followspot_persons.associate.motion`: the known velocity decays, and is driven by
noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_persons.associate.motion import step

SPEED_SIGMA, MEMORY = 0.5, 1.0
"""Sigma of the velocity of people in a room in the long run, m/s, of whom many stand, and the time constant
of its decay, s."""
VELOCITY_SIGMA = 0.25
"""Sigma of the error of a track's velocity, m/s. With the two above, 95 % of the forecasts of 37 rendered
recordings are in the ellipse after 0.2 to 2 s."""
PART_SIGMA = 0.25
"""Relative sigma of a distance by the size of a part of a body: that of the weakest boxes."""


@dataclass(frozen=True)
class Unseen:
    """Time since the picture last told a person's distance, and its direction, s.

    A picture tells only the direction of a person who is partly hidden.
    """

    distance: float = 0.0
    direction: float = 0.0

    def after(self, seconds: float, *, distance: bool, direction: bool) -> Unseen:
        """The same some seconds later, after a picture that tells these."""
        return Unseen(
            0.0 if distance else self.distance + seconds,
            0.0 if direction else self.direction + seconds,
        )

    def sigma(self, sight: Array) -> Array:
        """What it adds to the sigma of x and y, (2,) m, by quadrature; sight: (2,) from the camera, m.

        As long as a part of the person is seen, the size of this part limits the distance.
        """
        away = max(float(np.hypot(*sight)), 1e-6)
        along, across = sight / away, np.array([-sight[1], sight[0]]) / away
        hidden = walked(self.direction)
        partly = min(walked(self.distance - self.direction), PART_SIGMA * away)
        return np.asarray(np.hypot(along * np.hypot(partly, hidden), across * hidden))


def walked(seconds: float) -> float:
    """Sigma of the way of a person beside the forecast, along one axis, m."""
    motion = step(seconds, np.array(SPEED_SIGMA), np.array(MEMORY))
    return float(np.hypot(motion.position**0.5, VELOCITY_SIGMA * motion.reach))
