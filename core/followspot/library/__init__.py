"""followspot in scripts and notebooks: graphs composed, checked and run in Python, runs held by a handle.

Everything here is reached as ``import followspot as fs``.
"""
