"""Parts of `persons.pose_tracker`: how the fast instance follows known people."""
