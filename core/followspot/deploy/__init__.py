"""followspot.deploy"""
