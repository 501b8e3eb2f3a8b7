"""Who may do what: the authority that issues certificates, and the admission of control requests.

What Zenoh itself enforces (TLS, access control) is configured in `followspot.transport`.
"""
