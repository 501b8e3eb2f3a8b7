"""`followspot schema`: JSON Schema of graph, room and placement files, for completion in editors."""
