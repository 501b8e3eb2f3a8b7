"""From a plan to running workers: in this process, or one operating-system process each under a launcher.

Entry: `launch.run_plan`. Edges between processes are made here (`links`); what goes on inside a worker is
`followspot.runtime`.
"""
