"""followspot.plugins"""
