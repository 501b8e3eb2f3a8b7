"""followspot.testing"""
