"""Mistakes in rooms and placements."""

from __future__ import annotations

from tests.core.graph.broken_case import Broken

_CAM = """\
    kind: color
    size: [320, 240]
    matrix: [[250, 0, 160], [0, 250, 120], [0, 0, 1]]
    distortion: [0.1, 0, 0, 0, 0]
    rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    translation: [0, 0, 3]
"""
_SOURCE = "    source: {uses: toy.camera, with: {frames: 20}}\n"

ROOMS = [
    Broken("room", "room: stage", "room: stage\n¦camera: {}", 'a room has no key "camera"', '"cameras"?'),
    Broken(
        "room",
        "    kind: color\n",
        "    knd: color\n    kind: color\n".replace("knd", "¦knd"),
        'has no key "knd"',
    ),
    Broken("room", "  cam0:\n    kind: color\n", "  ¦cam0:\n", 'camera cam0 lacks "kind"'),
    Broken("room", "[0, 0, 3]", "[0, 0, ¦{a: 1}]", "holds a mapping", ""),
    Broken("room", "kind: color", "kind: ¦a b", 'kind cannot be "a b"', "one word"),
    Broken(
        "room", "kind: color", "kind: color\n    model: ¦pinhol", 'model cannot be "pinhol"', '"pinhole"?'
    ),
    Broken(
        "room",
        "kind: color",
        "kind: depth\n    model: ¦cylinder",
        "a depth camera cannot be a cylinder",
        "pinhole, rational, or fisheye",
    ),
    Broken("room", "size: [320, 240]", "size: ¦[320]", "size has 2 numbers, not 1"),
    Broken("room", "size: [320, 240]", "size: ¦[320, 0]", "whole pixels", "each from 1 to 32768"),
    Broken("room", "[[250, 0, 160]", "[[¦fx, 0, 160]", 'matrix holds "fx" where a finite number belongs'),
    Broken("room", "[[250, 0, 160]", "¦[[-250, 0, 160]", "this is no camera matrix", "positive fx and fy"),
    Broken(
        "room", "[[250, 0, 160]", "¦[[250, 160]", "matrix has 3 x 3 numbers, not rows of different length"
    ),
    Broken("room", "[0.1, 0, 0, 0, 0]", "¦[0.1, 0]", "distortion has 5 or 4 numbers, not 2"),
    Broken("room", "[0.1, 0, 0, 0, 0]", "[0.1, ¦.nan, 0, 0, 0]", "distortion holds nan"),
    Broken("room", "[[1, 0, 0], [0, 1, 0]", "¦[[1, 0, 0], [0, 2, 0]", "rows are not orthogonal unit vectors"),
    Broken("room", "[[1, 0, 0], [0, 1, 0]", "¦[[-1, 0, 0], [0, 1, 0]", "but a reflection", "negate one row"),
    Broken(
        "room",
        "    host: pc-left",
        "    clock_offset: ¦15",
        "clock_offset cannot be 15",
        "write a number from -1 to 1",
    ),
    Broken("room", "translation: [0, 0, 3]", "translation: ¦3", "translation is a list of 3 numbers, not 3"),
    Broken(
        "room",
        "  cam0:\n" + _CAM + _SOURCE,
        "  ¦cam0:\n" + _CAM,
        'camera "cam0" has no source, and stage "camera" needs it',
        "add source:",
    ),
    Broken(
        "room",
        "{uses: toy.camera, with: {frames: 20}}",
        "{uses: ¦toy.camra}",
        'no stage "toy.camra"',
        "toy.camera",
    ),
    Broken("room", "floor: [0, 0, 1, 0]", "floor: ¦[0, 0, 2, 0]", "has length 2, not 1", "divide all four"),
    Broken("room", "floor: [0, 0, 1, 0]", '¦"my floor": [0, 0, 1, 0]', "cannot be a name", "letters, digits"),
    Broken(
        "room", "floor: [0, 0, 1, 0]", f"¦{'f' * 101}: [0, 0, 1, 0]", "cannot be a name", "1 to 100 letters"
    ),
    Broken("room", "radius: 0.0762", "radius: ¦0", "radius cannot be 0", "greater than 0"),
    Broken("room", "  green:\n    radius: 0.0762\n", "  ¦green:\n", 'target green lacks "radius"'),
    Broken(
        "room",
        "{cam0: [12, 140]}",
        "{¦cam9: [12, 140]}",
        'the room has no camera "cam9"',
        "cameras: cam0, cam1",
    ),
    Broken(
        "room",
        "{cam0: [12, 140]}",
        "{cam0: ¦[140, 12]}",
        "area for cam0 cannot be [140, 12]",
        "[smallest, lar",
    ),
    Broken("room", "{cam0: [1, 0, 0,", "{cam0: ¦[1, 0,", "hue_histogram for cam0 has 16 numbers, not 15"),
    Broken("room", "{cam0: [1, 0,", "{cam0: ¦[1, -1,", "has a bin below 0"),
    Broken("room", "{cam0: [1, 0,", "{cam0: ¦[0, 0,", "has no bin above 0"),
    Broken(
        "room",
        "uses: toy.knowing, with: {path: truth.csv}",
        "uses: ¦toy.camera",
        "is a source of Truth or PoseTruth, and toy.camera",
    ),
]

PLACEMENTS = [
    Broken(
        "placement", "workers:", "¦wrokers: {}\nworkers:", 'a placement has no key "wrokers"', '"workers"?'
    ),
    Broken("placement", "placement: two", "¦by: stage", "either by or workers", "remove one"),
    Broken(
        "placement", "stages: [save]", "stages: [¦saev]", 'there is no stage "saev"', 'did you mean "save"?'
    ),
    Broken("placement", "cameras: [cam1]", "cameras: [¦cam7]", 'there is no camera "cam7"', "cam0, cam1"),
    Broken(
        "placement",
        "[detect/cam0]",
        "[detect/cam0, ¦save]",
        'stage "save" is placed twice',
        'worker "left" has it',
    ),
    Broken(
        "placement",
        "stages: [save]",
        "stages: ¦save",
        'stages is a list of names, not "save"',
        "stages: [NAME",
    ),
    Broken("placement", "stages: [save]", "¦stage: [save]", 'worker "left" has no key "stage"', '"stages"?'),
    Broken(
        "placement",
        "  right:",
        "  ¦empty: {host: pc}\n  right:",
        'worker "empty" runs nothing',
        "or remove it",
    ),
    Broken("placement", "  right:", '  ¦"a b":', '"a b" cannot be the name of a worker'),
    Broken("placement", "host: pc-left", "host: ¦7", "host is text, not 7", "quote"),
]
