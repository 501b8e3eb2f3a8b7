"""Control messages between operator, hosts and workers, their dispatch, and the carriers that move them."""
