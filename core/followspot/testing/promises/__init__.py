"""The promises of stages, one function each, which yields a text for each way in which a stage breaks it."""
