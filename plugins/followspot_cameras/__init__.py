"""Stages: cameras."""
