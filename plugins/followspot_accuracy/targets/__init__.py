"""Tracks of targets against their true trajectories (Jin & Qian 2008)."""
