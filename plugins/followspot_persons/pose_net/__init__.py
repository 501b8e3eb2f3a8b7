"""Joints of people by pose networks: regions of pictures in, decoded outputs of a user's model file out."""
