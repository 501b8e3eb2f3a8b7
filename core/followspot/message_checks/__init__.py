"""Checks of each message before its stage sends it: type and time, contract, and whether it fits the room."""
