"""What operator, host and worker say to each other: messages, and the carriers that move them."""
