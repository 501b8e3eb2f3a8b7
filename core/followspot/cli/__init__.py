"""The command `followspot`: one file a command, and `main`, which joins them with those of plugins."""
