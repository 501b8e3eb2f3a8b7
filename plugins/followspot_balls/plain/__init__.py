"""Fusion and life cycle exactly as Jin & Qian 2008 published them, without additions."""
