"""Glowing balls among interfering projections (Jin & Qian 2008): detection, pairing, fusion, filtering."""
