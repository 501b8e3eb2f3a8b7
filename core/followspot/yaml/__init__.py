"""YAML documents that users write: read into nodes with places, so that each mistake names line and column.

`reader` makes the nodes of a file, `form` reads what they say, key by key.
"""
