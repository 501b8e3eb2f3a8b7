"""Model files: ONNX through ONNX Runtime, TensorFlow Lite through OpenCV."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from followspot import Array
from followspot.files import TABLE, read_bytes
from followspot.plugins.extras import missing_extra
from followspot_persons.pose_net.contract import Session
from followspot_persons.pose_net.tflite_file import check_indices

SUFFIXES = (".onnx", ".tflite")
CRASHING = ".tflite"
"""Files that can make the library which reads them crash, if they are damaged."""
MOST_SIDE = 4096
"""Largest side of the picture that a model asks for, px."""
_ERRORS = 3
"""ONNX Runtime's level of messages about errors; it raises them besides."""


class MissingRuntime(Exception):
    """The package that reads the file is not installed; the text says how to install it."""


def open_session(path: Path) -> Session:
    """Load a model from the user's file.

    Raises OSError, MissingRuntime, or ValueError if the file is no model that can be run.
    """
    if path.suffix not in SUFFIXES:
        raise ValueError(f"its name ends in none of {', '.join(SUFFIXES)}")
    model = read_bytes(path, TABLE)
    return OnnxSession(model) if path.suffix == ".onnx" else OpenCvSession(model)


class OnnxSession:
    """A model of one input (1, H, W, 3) in ONNX Runtime, on one thread, for workers are the parallelism."""

    def __init__(self, model: bytes) -> None:
        try:
            import onnxruntime
        except ImportError:
            raise MissingRuntime(missing_extra("followspot", "onnxruntime")) from None
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = _ERRORS
        try:
            self.session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # each kind of invalid model has a class of its own
            raise ValueError(_first_line(error)) from None
        self.input, self.size = _input(self.session.get_inputs())

    def run(self, tensor: Array) -> Sequence[Array]:
        """The outputs. Raises ValueError if the model cannot take the input."""
        try:
            found = self.session.run(None, {self.input: tensor})
        except Exception as error:
            raise ValueError(_first_line(error)) from None
        return [np.asarray(output) for output in found if isinstance(output, np.ndarray)]


class OpenCvSession:
    """A TensorFlow Lite model in OpenCV, which takes planes of channels."""

    size = None

    def __init__(self, model: bytes) -> None:
        check_indices(model)
        try:
            self.net = _quietly(cv2.dnn.readNetFromTFLite, np.frombuffer(model, np.uint8))
            self.outputs = self.net.getUnconnectedOutLayersNames()
        except cv2.error as error:
            raise ValueError(_first_line(error)) from None
        if not self.outputs:
            raise ValueError("it has no outputs")

    def run(self, tensor: Array) -> Sequence[Array]:
        """The outputs. Raises ValueError if the model cannot take the input."""
        try:
            self.net.setInput(np.ascontiguousarray(tensor.transpose(0, 3, 1, 2)))
            return [np.array(output) for output in _quietly(self.net.forward, self.outputs)]
        except cv2.error as error:
            raise ValueError(_first_line(error)) from None


def _input(inputs: Sequence[Any]) -> tuple[str, tuple[int, int] | None]:
    """Name of the only input, and width and height if it says them. Raises ValueError."""
    if len(inputs) != 1 or len(inputs[0].shape) != 4:
        shapes = [each.shape for each in inputs]
        raise ValueError(f"it should have one input (1, height, width, 3), and has {shapes}")
    _, height, width, _ = inputs[0].shape
    if not (isinstance(height, int) and isinstance(width, int)):
        return inputs[0].name, None
    if not (1 <= height <= MOST_SIDE and 1 <= width <= MOST_SIDE):
        raise ValueError(f"its pictures have {width} x {height} px, at most {MOST_SIDE} a side are taken")
    return inputs[0].name, (width, height)


def _quietly(work: Any, *arguments: Any) -> Any:
    """Call OpenCV without its own account of an error, which is raised besides."""
    logging: Any = cv2.utils.logging
    level = logging.setLogLevel(logging.LOG_LEVEL_SILENT)
    try:
        return work(*arguments)
    finally:
        logging.setLogLevel(level)


def _first_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[0][:300] if lines else type(error).__name__
