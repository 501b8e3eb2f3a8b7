"""Plugins: installed stages (`catalogue`), those in use (`registry`), and the hooks of packages (`hooks`).

Discovery reads metadata and imports nothing; a stage's module is imported when a graph uses it.
"""
