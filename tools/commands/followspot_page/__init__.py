"""The operator's page: a run in a browser, while it runs. See docs/dashboard.md.

`hooks` is the command; `page_process` starts the process of a page, which `server` runs; `page` is its state.
Folders below `page`: what browsers draw (display), where it comes from (taps, recordings). Above it: what
browsers ask for (requests), and the web server (http).
"""
