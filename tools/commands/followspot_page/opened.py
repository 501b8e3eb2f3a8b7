"""A page that another page began: `python -m followspot_page.opened ORDER`, a `PageOrder` as JSON.

It prints its address, or why there is none, and ends with its run.
"""

from __future__ import annotations

import sys

import pydantic

from followspot.errors import FollowspotError
from followspot_page.page_process import PageOrder, shown


def main() -> int:
    """Entry of the process."""
    order: PageOrder = pydantic.TypeAdapter(PageOrder).validate_json(sys.argv[1])
    try:
        with shown(order) as page:
            print(page.url, flush=True)
            return page.wait()
    except FollowspotError as error:
        print(error, flush=True)
        return 1


if __name__ == "__main__":
    sys.exit(main())
