"""A message as bytes and back (docs/wire.md), for plugins that store or send messages themselves."""

from followspot.transport.codec import MAX_PACKED, codec_of, pack, unpack

__all__ = ["MAX_PACKED", "codec_of", "pack", "unpack"]
