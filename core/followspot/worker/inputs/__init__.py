"""The inputs of a stage: queues of messages, what they give a firing, and when it fires."""
