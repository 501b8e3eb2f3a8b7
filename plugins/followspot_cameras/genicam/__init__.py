"""GigE Vision and USB3 Vision cameras behind one interface, with the backends viva-genicam and Aravis."""
