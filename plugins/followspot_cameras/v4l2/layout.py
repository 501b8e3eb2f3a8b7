"""Structures and requests of V4L2 for the capture of pictures, as videodev2.h of Linux has them."""

from __future__ import annotations

import ctypes
from ctypes import Structure, Union, c_char, c_int, c_int32, c_int64, c_long, c_uint8, c_uint32, c_ulong

VIDEO_CAPTURE = 1
"""Type of buffers and formats: pictures in one plane that a camera captures."""
MAPPED = 1
"""Memory of buffers: the driver's, mapped into the process."""
HAS_CAPTURE, HAS_STREAMING, HAS_DEVICE_CAPS = 1, 0x0400_0000, 0x8000_0000
"""Flags of `Capability`."""
HAS_RATE = 0x1000
"""Flag of `StreamParameters`."""
QUEUED, DONE, DAMAGED = 0x2, 0x4, 0x40
"""Flags of `Buffer`: it waits for a picture, or has one, which is damaged."""
CLOCK, UNKNOWN, MONOTONIC = 0xE000, 0x0000, 0x2000
"""Flags of `Buffer`: mask of its clock, and two clocks."""
NEXT_CONTROL = 0x8000_0000
"""Set in the id of a control: asks for the one after it."""
DISABLED, READ_ONLY = 0x1, 0x4
"""Flags of `ControlQuery`."""


class Capability(Structure):
    """v4l2_capability: what a device is and can do."""

    _fields_ = (
        ("driver", c_char * 16),
        ("card", c_char * 32),
        ("bus_info", c_char * 32),
        ("version", c_uint32),
        ("capabilities", c_uint32),
        ("device_caps", c_uint32),
        ("reserved", c_uint32 * 3),
    )


class FormatDescription(Structure):
    """v4l2_fmtdesc: one of the formats of a device."""

    _fields_ = (
        ("index", c_uint32),
        ("type", c_uint32),
        ("flags", c_uint32),
        ("description", c_char * 32),
        ("pixelformat", c_uint32),
        ("mbus_code", c_uint32),
        ("reserved", c_uint32 * 3),
    )


class _PixelFormat(Structure):
    _fields_ = tuple(
        (name, c_uint32)
        for name in (
            *("width", "height", "pixelformat", "field", "bytesperline", "sizeimage"),
            *("colorspace", "priv", "flags", "ycbcr_enc", "quantization", "xfer_func"),
        )
    )


class _AnyFormat(Union):
    _fields_ = (("pix", _PixelFormat), ("raw", c_uint8 * 200), ("aligned", c_ulong))


class Format(Structure):
    """v4l2_format: size and format of the pictures."""

    _fields_ = (("type", c_uint32), ("fmt", _AnyFormat))


class BufferRequest(Structure):
    """v4l2_requestbuffers: how many buffers are wanted, then how many there are."""

    _fields_ = (
        ("count", c_uint32),
        ("type", c_uint32),
        ("memory", c_uint32),
        ("capabilities", c_uint32),
        ("reserved", c_uint8 * 4),
    )


class _Time(Structure):
    _fields_ = (("seconds", c_long), ("microseconds", c_long))


class _Place(Union):
    _fields_ = (("offset", c_uint32), ("userptr", c_ulong))


class Buffer(Structure):
    """v4l2_buffer: a buffer, and the picture in it."""

    _fields_ = (
        ("index", c_uint32),
        ("type", c_uint32),
        ("bytesused", c_uint32),
        ("flags", c_uint32),
        ("field", c_uint32),
        ("timestamp", _Time),
        ("timecode", c_uint32 * 4),
        ("sequence", c_uint32),
        ("memory", c_uint32),
        ("m", _Place),
        ("length", c_uint32),
        ("reserved2", c_uint32),
        ("request_fd", c_uint32),
    )


class StreamParameters(Structure):
    """v4l2_streamparm of a capture: the time from one picture to the next, s, as a fraction."""

    _fields_ = (
        ("type", c_uint32),
        ("capability", c_uint32),
        ("capturemode", c_uint32),
        ("numerator", c_uint32),
        ("denominator", c_uint32),
        ("rest", c_uint32 * 46),
    )


class ControlQuery(Structure):
    """v4l2_queryctrl: a control, its kind and its limits."""

    _fields_ = (
        ("id", c_uint32),
        ("type", c_uint32),
        ("name", c_char * 32),
        ("minimum", c_int32),
        ("maximum", c_int32),
        ("step", c_int32),
        ("default_value", c_int32),
        ("flags", c_uint32),
        ("reserved", c_uint32 * 2),
    )


class _MenuEntry(Union):
    _pack_ = 1
    _fields_ = (("name", c_char * 32), ("value", c_int64))


class MenuQuery(Structure):
    """v4l2_querymenu: an entry of a menu, by its name or its value."""

    _pack_ = 1
    _fields_ = (("id", c_uint32), ("index", c_uint32), ("entry", _MenuEntry), ("reserved", c_uint32))


class Control(Structure):
    """v4l2_control: a value for a control."""

    _fields_ = (("id", c_uint32), ("value", c_int32))


class BufferType(Structure):
    """The integer that begins or ends the stream of a type of buffers."""

    _fields_ = (("type", c_int),)


def _request(number: int, form: type[Structure], *, read: bool, write: bool) -> int:
    """The number of a request, by the macros _IOR, _IOW and _IOWR of Linux."""
    direction = 2 * read + write
    return direction << 30 | ctypes.sizeof(form) << 16 | ord("V") << 8 | number


QUERYCAP = _request(0, Capability, read=True, write=False)
ENUM_FMT = _request(2, FormatDescription, read=True, write=True)
G_FMT = _request(4, Format, read=True, write=True)
S_FMT = _request(5, Format, read=True, write=True)
REQBUFS = _request(8, BufferRequest, read=True, write=True)
QUERYBUF = _request(9, Buffer, read=True, write=True)
QBUF = _request(15, Buffer, read=True, write=True)
DQBUF = _request(17, Buffer, read=True, write=True)
STREAMON = _request(18, BufferType, read=False, write=True)
STREAMOFF = _request(19, BufferType, read=False, write=True)
G_PARM = _request(21, StreamParameters, read=True, write=True)
S_PARM = _request(22, StreamParameters, read=True, write=True)
S_CTRL = _request(28, Control, read=True, write=True)
QUERYCTRL = _request(36, ControlQuery, read=True, write=True)
QUERYMENU = _request(37, MenuQuery, read=True, write=True)
