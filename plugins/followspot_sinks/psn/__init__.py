"""PosiStageNet, for lighting desks."""
