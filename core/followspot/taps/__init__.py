"""Messages of ports of a run that has begun, for other processes: taps send, receivers read.

A tap never waits. It leaves out what its receiver does not take in time, and the numbers of the messages tell
how many are missing.
"""
