"""followspot.cli"""
