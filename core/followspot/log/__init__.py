"""The log of a run: workers collect records, hosts keep the newest ones, and a file keeps all."""
