"""The inputs of a stage: queues of messages, the messages of each firing, and when it fires."""
