"""From graph files to one flat mapping of stages: overlays are merged, sub-graphs are put in their places."""
