"""Histograms of oriented gradients: features, detector and search windows."""
