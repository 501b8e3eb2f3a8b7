"""Pairs of blobs over views: which show one ball, where their rays meet (Jin & Qian 2008, 3.4 and 3.5)."""
