"""Sources of pictures (video files, image folders, devices, network streams) and of recorded truth."""

import os

# Decoders complain on standard error; what matters of it is said by the stages.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
os.environ.setdefault("OPENCV_LOG_LEVEL", "ERROR")
