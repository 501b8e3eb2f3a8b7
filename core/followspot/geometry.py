"""Multi-view geometry after Hartley & Zisserman: projection, undistortion, triangulation, pair relations.

All functions are pure and vectorised over points. Pixels are undistorted unless a name says otherwise.
"""
