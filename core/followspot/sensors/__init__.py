"""What sources of inertial readings share: clocks of devices, batches of readings, stuck readings."""
