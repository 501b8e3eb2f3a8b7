"""Which names and numbers from files, other processes and hosts are valid."""
