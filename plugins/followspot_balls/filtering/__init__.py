"""Kalman filter of targets, and positions that are predicted instead of measured (Jin & Qian 2008, 3.7)."""
