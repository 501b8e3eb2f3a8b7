"""Edges between workers: what may cross a process boundary, and how.

Entry: `edge.PortWriter` and `edge.PortReader`, with two kinds behind them: the ring in shared memory
(`ring_writer`, `ring_reader`) within a host, Zenoh (`zenoh_edge`) between hosts. An edge within one worker
is a call and needs nothing of this. Not here: when a stage fires, what is counted, who connects whom.
"""
