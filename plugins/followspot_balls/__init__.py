"""Stages: balls."""
