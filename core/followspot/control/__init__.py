"""Control messages between operator, hosts and workers, their dispatch, and the carriers that move them."""

from followspot.operating_system.requirements import check_system

check_system()  # here, for what the roles import needs it, too
