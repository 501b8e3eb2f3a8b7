"""The glow of a ball: its light on a nearby plane shifts its centre towards the plane in colour cameras.

The shift is up to 2 cm and equal in all colour cameras, so they agree on a wrong position.
Infrared cameras do not see the light: with the shift as an unknown they determine the position.
"""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def glow_sigma(clearance: Array, touching: float, reach: float) -> Array:
    """Sigma of the shift, m: `touching` for a ball that touches the plane, 0 at the clearance `reach`, m.

    The quadratic decay fits ray-traced balls: 2 cm at the floor and 1 cm at a clearance of 10 cm.
    """
    return np.asarray(touching * np.square(np.maximum(1 - clearance / reach, 0.0)))
