"""Sources of pictures (video files, image folders, devices, network streams) and of recorded truth."""
