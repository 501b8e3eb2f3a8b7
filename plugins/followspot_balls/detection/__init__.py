"""Balls in one picture: search regions, components, hues, and centres (Jin & Qian 2008, section 3.3)."""
