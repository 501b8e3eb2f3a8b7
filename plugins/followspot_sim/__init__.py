"""Stages: sim."""
