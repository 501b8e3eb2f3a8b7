"""From a plan to running workers: in this thread, as processes of this host, or on many hosts under agents.

Entry: `launch.run_plan`. A `Coordinator` speaks with each host's part of a run (`host.Host`), which is near
(`LocalHost`) or far. Edges between processes are made here (`links`); what goes on inside a worker is
`followspot.worker`. `changes` swaps, sets and moves stages of a run; `clocks` compares those of its hosts;
`security` says who may.
"""
