"""Tracks of people: association, update, initiation, confirmation and deletion."""
