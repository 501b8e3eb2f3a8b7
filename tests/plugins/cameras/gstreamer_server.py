"""A network camera by GStreamer, run by the system's Python: gstreamer_server.py PORT PIPELINE.

Prints a line when it runs, and ends when its input ends.
"""

from __future__ import annotations

import sys
import threading


def main(port: str, pipeline: str) -> None:
    import gi

    gi.require_version("Gst", "1.0")
    gi.require_version("GstRtspServer", "1.0")
    from gi.repository import GLib, Gst, GstRtspServer

    Gst.init(None)
    server = GstRtspServer.RTSPServer.new()
    server.set_address("127.0.0.1")
    server.set_service(port)
    factory = GstRtspServer.RTSPMediaFactory.new()
    factory.set_launch(pipeline)
    server.get_mount_points().add_factory("/cam", factory)
    loop = GLib.MainLoop()

    def until_input_ends() -> None:
        sys.stdin.read()
        loop.quit()

    if server.attach(None):
        print("running", flush=True)
        threading.Thread(target=until_input_ends, daemon=True).start()
        loop.run()


if __name__ == "__main__":
    main(*sys.argv[1:])
