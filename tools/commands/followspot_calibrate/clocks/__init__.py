"""Calibration of clocks: how much later than its time stamps say each camera takes its pictures."""
