"""Templates of targets, as they glow in a dark room or in one picture (Jin & Qian 2008, section 3.2)."""
