"""The page's process: `python -m followspot_page.server ORDER`, a `PageOrder` as JSON."""

from __future__ import annotations

import asyncio
import logging
import sys
from contextlib import ExitStack

import pydantic

from followspot.errors import FollowspotError
from followspot.library.handle import RunHandle, connected_run
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.plugins.registry import use_plugin_files
from followspot.taps.receivers import LocalReceiver
from followspot_dashboard.gate import SOCKET, make_gate
from followspot_page.address import is_loopback
from followspot_page.display.feed import Arrivals
from followspot_page.http.routes import input_over, listening_socket, server_of
from followspot_page.page import Page
from followspot_page.page_process import PageOrder, address
from followspot_page.recording_page import serve_recording
from followspot_page.run_list import RunList, announced
from followspot_page.taps.live_run import Sight, follow, found, plan_of, remote_previews


async def serve(order: PageOrder) -> None:
    """Serve the page of a run until the run or standard input ends.

    Raises OSError if the address cannot be bound, FollowspotError if the run refuses taps.
    """
    with TemporaryFolder("page") as made, ExitStack() as connection:
        folder = made.path
        endpoint = listening_socket(order.host, order.port, firm=order.firm)
        endpoint.listen()  # browsers that connect before the run has begun wait
        print(endpoint.getsockname()[1], flush=True)
        over = input_over()
        waiting = asyncio.ensure_future(_run(order, connection))
        await asyncio.wait((waiting, over), return_when=asyncio.FIRST_COMPLETED)
        if over.done():
            waiting.cancel()
            return
        run = waiting.result()
        page = Page(await plan_of(run), make_gate(folder), folder)
        receiver = LocalReceiver(folder / SOCKET, Arrivals(page.previews.take).consume)
        page.remote = await remote_previews(run, page.previews.take)
        page.sight = sight = Sight(run, folder, order.rate, page.remote)
        await sight.turn_to(page.plan)
        server = server_of(page, order.host, endpoint.getsockname()[1])
        serving = asyncio.ensure_future(server.serve([endpoint]))
        following = asyncio.ensure_future(follow(run, sight, page.take_status, page.show, page.take_kept))
        if is_loopback(order.host):
            page.runs = RunList(order, run.run)
            connection.enter_context(announced(run.run, address(order.host, endpoint.getsockname()[1])))
            await page.allow_changes(run)
        await asyncio.wait((serving, following, over), return_when=asyncio.FIRST_COMPLETED)
        if following.done():
            await page.end("over or gone")
        elif over.done() and over.result():
            await page.end("ended")
        server.should_exit = True
        await serving
        following.cancel()
        await sight.close()
        await page.button.close()
        receiver.close()
        if page.remote is not None:
            page.remote.close()


async def _run(order: PageOrder, connection: ExitStack) -> RunHandle:
    """The run that is shown: under agents, connected until the stack closes, or that of a process here."""
    if not order.run:
        return await found(order.pid)
    use_plugin_files(order.plugin_files)
    return await asyncio.to_thread(connection.enter_context, connected_run(order.run, order.network))


def _order(text: str) -> PageOrder:
    """The order from JSON."""
    return pydantic.TypeAdapter(PageOrder).validate_json(text)


def main() -> int:
    """Entry of the process."""
    logging.getLogger("asyncio").setLevel(logging.ERROR)  # otherwise uvicorn logs browsers that left
    try:
        order = _order(sys.argv[1])
        asyncio.run(serve_recording(order) if order.recording else serve(order))
    except OSError as error:
        print(f"error {error.strerror or error}; name another with --dashboard-at", flush=True)
        return 1
    except FollowspotError as error:
        print(f"error {error}", flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
