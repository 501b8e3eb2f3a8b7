"""How the documents become pages: `make docs`."""

project = "followspot"
author = "the followspot developers"
extensions = ["myst_parser"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "followspot"
html_show_sourcelink = False
html_show_copyright = False
exclude_patterns = ["_build"]
