"""Sinks: files, the console, pictures, and protocols in which other programs are told where things are."""
