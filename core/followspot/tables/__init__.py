"""Tables for people: their columns, and how terminals and notebooks show them.

`followspot.message_table` makes the columns of a message.
"""
