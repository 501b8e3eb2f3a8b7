"""Glowing balls among interfering projections (Jin & Qian 2008): detection, pairing, fusion, filtering.

Modules here are stages, and what several of them use. Parts of one stage, or of one idea, have a folder. In
the order of the pipeline: templates of targets, detection in pictures and in depth images, measurement (how
a ball shows in cameras), pairs of blobs, places from a single view, the association with targets, and
fusion. Beside it: the published method without additions (plain), inertial navigation, smoothing, and throws.
"""
