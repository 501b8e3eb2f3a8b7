"""Balls in one picture: where to look, components, hues, and centres (Jin & Qian 2008, section 3.3)."""
