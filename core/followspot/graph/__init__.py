"""followspot.graph"""
