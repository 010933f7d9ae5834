#!/usr/bin/env python3
"""Makes one animated PNG of pictures of the same size.

usage: animate.py OUT.png MILLISECONDS:IN.png...

The pictures must be 8-bit RGB without interlacing, as `lodestream render` writes them. Each is shown for its time; the animation
repeats. Source: APNG Specification, https://wiki.mozilla.org/APNG_Specification.
"""

import struct
import sys
import zlib
from pathlib import Path

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def chunks(data):
    """Yields name and content of each chunk of a PNG."""
    at = len(SIGNATURE)
    while at < len(data):
        (length,) = struct.unpack(">I", data[at:at + 4])
        yield data[at + 4:at + 8], data[at + 8:at + 8 + length]
        at += length + 12


def chunk(name, content):
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def animate(frames):
    """@param frames: milliseconds and the bytes of a PNG. @return the bytes of the animation."""
    parts = [SIGNATURE]
    number = 0
    head = None
    for milliseconds, png in frames:
        content = {name: b"" for name in (b"IHDR", b"IDAT")}
        for name, data in chunks(png):
            if name in content:
                content[name] += data
        if head is None:
            head = content[b"IHDR"]
            parts += [chunk(b"IHDR", head), chunk(b"acTL", struct.pack(">II", len(frames), 0))]
        if content[b"IHDR"] != head:
            sys.exit("animate.py: the pictures differ in size or kind")
        width, height = struct.unpack(">II", head[:8])
        control = struct.pack(">IIIIIHHBB", number, width, height, 0, 0, milliseconds, 1000, 0, 0)
        parts.append(chunk(b"fcTL", control))
        number += 1
        if number == 1:
            parts.append(chunk(b"IDAT", content[b"IDAT"]))
        else:
            parts.append(chunk(b"fdAT", struct.pack(">I", number) + content[b"IDAT"]))
            number += 1
    return b"".join(parts + [chunk(b"IEND", b"")])


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__.split("\n\n")[1])
    frames = []
    for argument in sys.argv[2:]:
        milliseconds, _, name = argument.partition(":")
        frames.append((int(milliseconds), Path(name).read_bytes()))
    Path(sys.argv[1]).write_bytes(animate(frames))


main()
