"""`followspot shape`: makes the shape model and the relations between colours that pose tracking uses."""
