"""Sinks: tracks and detections as CSV, any message as JSON lines, targets on the console."""
