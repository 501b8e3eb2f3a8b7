"""Inertial sensors that send datagrams."""
