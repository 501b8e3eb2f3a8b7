"""Inflict faults at random on a live run on several hosts; `--help` says how."""

import sys

from soaking.campaign import main

if __name__ == "__main__":
    sys.exit(main())
