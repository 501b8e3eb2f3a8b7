"""Try to break everything that reads what others wrote; `--help` says how."""

import sys

from fuzzing.campaign import main

if __name__ == "__main__":
    sys.exit(main())
