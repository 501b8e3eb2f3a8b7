"""The host's role: starts the workers of a run on one machine, supervises them and connects them by rings.

An agent has this role on a remote machine, the operator's own process on its machine (`LocalHost`). `clocks`
measures the offsets between the clocks of the hosts.
"""
