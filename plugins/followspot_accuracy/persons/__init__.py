"""Poses of persons against their true poses (Weinrich et al. 2010)."""
