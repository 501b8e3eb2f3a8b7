"""The web server of a page: its routes, access control, and the socket of each browser."""
