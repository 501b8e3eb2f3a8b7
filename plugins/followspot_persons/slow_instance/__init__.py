"""Parts of `persons.appearance`: what the slow instance finds and learns."""
