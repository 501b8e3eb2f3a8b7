"""Fusion and life cycle exactly as Jin & Qian 2008 published them, without what this project added."""
