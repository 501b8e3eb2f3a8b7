"""Recordings on the page: the button that makes one, and the moments of one that browsers seek."""
