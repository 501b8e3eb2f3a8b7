"""Security of runs over hosts: the certificate authority, the grants of a host, the guard of its requests.

`followspot.transport` configures what Zenoh itself enforces: TLS and access control.
"""
