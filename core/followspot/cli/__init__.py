"""The command `followspot`: a file for each command, and `main`, which adds the commands of plugins."""
