"""Upper body and head pose of people (Weinrich, Müller & Gross 2010): edges, colour, HOG, particles."""
