"""What a run was: its report, its scores, where it fell silent, and the summary for people."""
