"""Which detections are one body: likelihood ratios, clusters over cameras, probabilities."""
