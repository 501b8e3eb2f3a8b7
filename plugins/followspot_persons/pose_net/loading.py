"""The network of a stage, loaded once for all cameras of a worker and tried before it is used."""

from __future__ import annotations

from pathlib import Path
from weakref import WeakValueDictionary

import numpy as np

from followspot.errors import InputError, Mistake, did_you_mean
from followspot_persons.pose_net.apart import try_apart
from followspot_persons.pose_net.contract import Decoder, Decoders, Network
from followspot_persons.pose_net.sessions import CRASHING, MissingRuntime, open_session

_loaded: WeakValueDictionary[tuple[object, ...], Network] = WeakValueDictionary()
"""Networks that a stage holds, by file and decoder."""
_tried: set[tuple[object, ...]] = set()
"""Files and decoders that have crashed no process."""


def network(path: Path, decoder: type[Decoder]) -> Network:
    """The network of a model file, shared with all stages of this process that use the same.

    Raises InputError if the file holds no model that the decoder understands, and with the remedy if the
    package that runs it is not installed.
    """
    try:
        status = path.stat()
        key = (str(path.resolve()), status.st_mtime_ns, status.st_size, decoder)
        found = _loaded.get(key)
        if found is None:
            if path.suffix == CRASHING and key not in _tried:
                try_apart(path, decoder)
                _tried.add(key)
            found = _loaded[key] = loaded(path, decoder)
    except MissingRuntime as error:
        text = f"persons.pose_net needs ONNX Runtime for {path}, which is not installed"
        raise InputError([Mistake(None, text, str(error))]) from None
    except (OSError, ValueError, IndexError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        text = f"{path} is no model that {decoder.__name__} understands: {reason}"
        raise InputError([Mistake(None, text, "docs/pose_nets.md says which files fit")]) from None
    return found


def decoder_named(name: str, decoders: Decoders) -> type[Decoder]:
    """The decoder of a name. Raises InputError if there is none."""
    if name not in decoders:
        text = f'no decoder is called "{name}"'
        raise InputError([Mistake(None, text, did_you_mean(name, decoders, "decoders"))])
    return decoders[name]


def loaded(path: Path, decoder: type[Decoder]) -> Network:
    """The network of a file, after a black image.

    Raises as `open_session`, and ValueError or IndexError if its outputs are not what the decoder expects.
    """
    network = Network(open_session(path), decoder())
    width, height = network.size or (2 * network.decoder.multiple, 2 * network.decoder.multiple)
    network.people([np.zeros((height, width, 3), np.uint8)])
    return network
