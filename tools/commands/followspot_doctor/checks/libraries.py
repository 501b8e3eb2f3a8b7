"""The build of OpenCV: it decodes videos and has the detectors that plugins use."""

from __future__ import annotations

from collections.abc import Iterator

from followspot_doctor.finding import Finding, doubtful, fine, wrong

_REMEDY = "pip install 'opencv-python-headless>=4.14,<5'"


def opencv() -> Iterator[Finding]:
    """Version, FFmpeg, Video4Linux, HOG."""
    try:
        import cv2
    except ImportError as error:
        yield wrong("opencv", f"cannot be imported: {error}", _REMEDY)
        return
    text = f"OpenCV {cv2.__version__}"
    backends = {
        cv2.videoio_registry.getBackendName(backend) for backend in cv2.videoio_registry.getBackends()
    }
    if not hasattr(cv2, "HOGDescriptor"):
        yield wrong("opencv", f"{text} has no HOG detector", _REMEDY)
    elif "FFMPEG" not in backends:
        yield doubtful("opencv", f"{text} without FFmpeg reads few videos and no streams", _REMEDY)
    else:
        yield fine("opencv", f"{text} with {', '.join(sorted(backends & {'FFMPEG', 'V4L2'}))} and HOG")
