"""Corrects cameras that are slightly off by what an ordinary tracking run saw."""
