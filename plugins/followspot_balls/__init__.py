"""Glowing balls among interfering projections (Jin & Qian 2008): detection, pairing, fusion, filtering.

Each module here is a stage. Its parts, and what several stages use, are in one folder for each idea, in the
order of the pipeline: templates of targets, detection in pictures, depth (detection in depth images),
measurement (how a ball shows in cameras), pairs of blobs, single_view (positions from one camera),
association of candidates with targets, fusion and filtering. scene is what the room and the forecast tell of
planes and targets. Beside it: the published method without additions (plain), inertial navigation,
smoothing, and throws.
"""
