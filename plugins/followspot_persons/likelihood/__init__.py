"""How likely a pose of a person is, given a picture."""
