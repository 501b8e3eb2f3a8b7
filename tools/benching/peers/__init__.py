"""The six-camera tracker by other means: the same stages, joined by a pipeline, ezmsg or dora."""
