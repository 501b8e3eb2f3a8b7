"""Upper body and head pose of people (Weinrich, Müller & Gross 2010): edges, colour, HOG, particles.

Modules here are stages, and what several of them use. Parts of one stage, or of one idea, have a folder: the
model of a body, the background, colours, HOG, the likelihood of a pose, its particle filter, the two
instances of the tracker (slow_instance finds and recognises people, fast_instance tracks them), networks
(pose_net), the association of detections in several cameras (associate), and the fusion of poses
(pose_fusion).
"""
