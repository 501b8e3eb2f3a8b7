"""The Rerun viewer."""
