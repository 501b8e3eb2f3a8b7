"""The operator's role: starts a run on its hosts, watches and changes it, and reports its end."""
