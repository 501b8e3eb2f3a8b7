"""Network cameras over RTSP, with the capture times that their RTCP sender reports tell."""
