"""The log of a run: workers collect records, hosts keep the newest of them, a file keeps all."""
