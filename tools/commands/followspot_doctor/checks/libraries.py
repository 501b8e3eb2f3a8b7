"""The build of OpenCV, which decodes videos and has the detectors that plugins use; optional packages."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec

from followspot_doctor.finding import Finding, doubtful, fine, wrong

_REMEDY = "pip install 'opencv-python-headless>=4.14,<5'"

EXTRAS = {
    "certs": ("cryptography", "followspot certs, to issue certificates"),
    "dashboard": ("starlette", "the page of a run"),
    "imu": ("vqf", "imu.orientation with method vqf"),
    "lsl": ("pylsl", "lsl.stream and lsl.outlet"),
    "parquet": ("pyarrow", "export --to parquet, tables of sweep"),
    "plots": ("matplotlib", "pictures of compare, score and sweep"),
    "posenet": ("onnxruntime", "persons.pose_net with models .onnx"),
    "recording": ("mcap", "run --record and --keep, replay, verify, export"),
    "rerun": ("rerun", "sinks.rerun, export --to rerun"),
}
"""Extras that are for more than stages, for which the check of plugins speaks: their module, and for what."""


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


def extras() -> Iterator[Finding]:
    """A finding for each extra that is not installed; that is no problem."""
    for extra, (module, purpose) in EXTRAS.items():
        if find_spec(module) is None:
            yield fine(f"extra {extra}", f"not installed: pip install 'followspot[{extra}]' ({purpose})")
