"""A message as bytes and back (docs/wire.md), for plugins that store or send messages themselves."""

from followspot.transport.codec import MAX_PACKED, codec_of, header_of, pack, unpack
from followspot.transport.row_differences import differenced, restored

__all__ = ["MAX_PACKED", "codec_of", "differenced", "header_of", "pack", "restored", "unpack"]
