"""The page of a recording, served until standard input ends."""

from __future__ import annotations

import asyncio

from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot_dashboard.gate import make_gate
from followspot_page.http.routes import input_over, listening_socket, server_of
from followspot_page.page import Page
from followspot_page.page_process import PageOrder
from followspot_page.recordings.scrub import Scrub
from followspot_page.taps.shown_ports import shown_ports
from followspot_record.embedded import recorded_plan
from followspot_recording.recording import Recording


async def serve_recording(order: PageOrder) -> None:
    """Serve the page of a recording. Raises OSError, FollowspotError if the recording cannot be shown."""
    with (
        TemporaryFolder("page") as made,
        Recording(order.recording) as recording,
    ):
        plan = recorded_plan(recording, order.plugin_files)
        endpoint = listening_socket(order.host, order.port, firm=order.firm)
        page = Page(plan, make_gate(made.path), made.path)
        scrub = Scrub(recording, shown_ports(plan), page.previews.take, page.send_position, order.rate)
        page.show_recording(scrub)
        endpoint.listen()
        print(endpoint.getsockname()[1], flush=True)
        server = server_of(page, order.host, endpoint.getsockname()[1])
        serving = asyncio.ensure_future(server.serve([endpoint]))
        showing = asyncio.ensure_future(scrub.serve())
        await asyncio.wait((serving, showing, input_over()), return_when=asyncio.FIRST_COMPLETED)
        await page.end("closed")
        server.should_exit = True
        await serving
        showing.cancel()
        if showing.done() and not showing.cancelled():
            showing.result()
