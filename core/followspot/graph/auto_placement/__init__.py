"""`--placement auto`: workers chosen by the measured work of stages and a model of the pipeline."""
