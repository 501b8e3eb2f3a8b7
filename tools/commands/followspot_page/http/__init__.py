"""The web server of a page: its routes, who may enter, and the socket of each browser."""
