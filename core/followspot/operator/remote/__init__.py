"""Hosts behind agents: their orders, their status, and runs that were left there."""
