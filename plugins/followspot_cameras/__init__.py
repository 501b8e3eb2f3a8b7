"""Sources of pictures (video files, image folders, devices, network streams) and of recorded truth."""

import os

# The stages report what matters of the decoders' messages on standard error.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
os.environ.setdefault("OPENCV_LOG_LEVEL", "ERROR")
