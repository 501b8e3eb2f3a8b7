"""What runs need of the operating system: services, limits, child processes, descriptors and the clock."""
