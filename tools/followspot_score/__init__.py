"""Command package: see hooks.py."""
