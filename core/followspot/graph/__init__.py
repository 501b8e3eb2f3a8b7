"""From graph, room and placement files to a plan; pure data and pure functions, nothing is started.

load -> `Loaded` -> expand -> `Expanded` -> check -> `Checked` -> place and arrange -> `Plan`. The entry is
`followspot.graph.compile.compile_graph`; `ship` sends a plan to other processes, `show` to people.
"""
