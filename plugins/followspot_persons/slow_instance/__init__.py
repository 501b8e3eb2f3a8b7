"""Parts of `persons.appearance`: how the slow instance finds people and learns their appearance."""
