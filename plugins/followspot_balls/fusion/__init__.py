"""Fusion of the candidates of each target into one position and its covariance (Jin & Qian 2008, 3.6)."""
