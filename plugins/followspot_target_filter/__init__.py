"""Filtering of targets: the stage `TargetFilter` with their life cycle; a plugin gives the motion model."""
