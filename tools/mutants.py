"""Change the code at random places and list the changes that no test notices; `--help` says how."""

import sys

from mutation.campaign import main

if __name__ == "__main__":
    sys.exit(main())
