"""followspot.transport"""
