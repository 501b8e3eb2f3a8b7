"""The commands `followspot demo` and `followspot graphs`: the graphs that are installed with followspot."""
