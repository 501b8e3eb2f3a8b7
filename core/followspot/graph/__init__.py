"""From graph, room and placement files to a plan; pure data and pure functions, nothing is started.

load -> `LoadedGraph` -> expand -> `ExpandedGraph` -> check -> `CheckedGraph` -> place and arrange ->
`Plan`. The entry is `followspot.graph.compile.compile_graph`. `plan_data` turns a plan into JSON types and
back, for other processes; `drawing` shows it to people.
"""
