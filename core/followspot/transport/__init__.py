"""Edges between workers of different processes and hosts.

Entry: `edge.PortWriter` and `edge.PortReader`, with two kinds behind them: the ring in shared memory (`ring`)
within a host, Zenoh (`zenoh`) between hosts. Writers hold back until readers give credit, which is the
backpressure of an edge. An edge within one worker is a call and needs nothing of this package. Firing,
counting and connecting belong to `followspot.worker`.
"""
