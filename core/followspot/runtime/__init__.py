"""followspot.runtime"""
