"""Video4Linux2 (V4L2): cameras as the kernel of Linux offers them."""
