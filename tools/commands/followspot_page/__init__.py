"""The operator's page: a run in a browser, while it runs. See docs/dashboard.md."""
