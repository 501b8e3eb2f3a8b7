"""Bundle adjustment (Triggs et al. 2000): the cameras and points that agree best with the sightings."""

from followspot_calibrate.adjust.levenberg import Adjusted, Progress, adjust
from followspot_calibrate.adjust.prior import Prior
from followspot_calibrate.adjust.problem import Anchors, Middle
from followspot_calibrate.adjust.projection import Free
from followspot_calibrate.adjust.rods import Rods

__all__ = ["Adjusted", "Anchors", "Free", "Middle", "Prior", "Progress", "Rods", "adjust"]
