"""Files of points that several cameras saw: CSV, the toolbox of Svoboda et al., keypoints as NPZ."""

from followspot_calibrate.points_file.reading import read_points

__all__ = ["read_points"]
