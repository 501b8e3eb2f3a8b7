"""What every stage promises, one function a promise: a text for every way in which it is broken."""
