"""Recorded videos as cameras: played, played as if live, or as another camera would have taken them."""
