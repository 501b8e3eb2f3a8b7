"""The report of a run: figures, scores, stages that gave nothing, and the summary for people."""
