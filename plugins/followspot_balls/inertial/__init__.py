"""Inertial navigation of targets: camera positions fused with readings of a sensor on the target.

The method is an error-state Kalman filter (Sola 2017, arXiv 1711.02508, sections 5 and 6) whose error of
orientation is in axes of the room, after Groves, Principles of GNSS, Inertial, and Multisensor Integrated
Navigation Systems (2013), chapter 14. Before it begins, the heading is learnt
from the motion alone.
"""
