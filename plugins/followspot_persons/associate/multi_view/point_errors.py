"""Errors of the points that networks find in pictures."""

WRONG = 0.1
"""Share of a network's points that are anywhere."""
INDEPENDENT = 4
"""Points of a body whose errors are independent: more of them are no more evidence."""
OUTLIER = 9.0
"""Squared normalised distance above which a point's variance grows with it: a bound on its influence."""
