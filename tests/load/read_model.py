#!/usr/bin/python3
"""Reads a whole model from a server and checks the digest of every blob. This client was written from docs/protocol.md and
docs/store-format.md alone. It needs Debian's python3-flatbuffers and, on PYTHONPATH, the output of `flatc --python
--gen-onefile --gen-object-api proto/lodestream.fbs`. Prints one JSON object with the results.

    read_model.py HOST:PORT MODEL [TOKEN]
"""
import collections
import hashlib
import json
import socket
import struct
import sys

import flatbuffers
import lodestream_generated as wire

HEADER = struct.Struct("<IBBHI")  # body bytes, type, flags, zero, call
BLOB = struct.Struct("<III")  # request, total, offset
TYPES = dict(Hello=1, Welcome=2, Open=5, Opened=6, Requests=7, Credit=8, Blob=9, Cancelled=10, Error=11, GoAway=12,
             ModelReplaced=13, Ping=14, Pong=15)
NAMES = {number: name for name, number in TYPES.items()}
NO_SUCH_MODEL, LIMIT, DAMAGED_STORE = 5, 7, 8  # codes of an Error
VERSION = 4  # version of the protocol
OPTIONAL, MAX_BODY, WINDOW, MAX_CHANGES, INNER_TEXELS = 1, 262144, 65536, 4096, 508

Ref = collections.namedtuple("Ref", "number bytes name")


class Bytes:
    """Reads the values that store-format.md calls u8, u64, varint and so on, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def read(self, form):
        self.at += struct.calcsize("<" + form)
        assert self.at <= len(self.data), "cut off"
        values = struct.unpack_from("<" + form, self.data, self.at - struct.calcsize("<" + form))
        return values[0] if len(values) == 1 else values

    def varint(self):
        byte = self.read("B")
        return byte if byte < 128 else byte - 128 + 128 * self.varint()

    def reference(self):
        number = self.varint()
        return Ref(number, self.varint(), self.read("16s")) if number else None


def page_references(data):
    """Returns the references of a page to other pages and to payloads (None for an empty reference), and the number of LODs of
    its first node."""
    page, pages, payloads, lods = Bytes(data), [], [], []
    assert page.read("B") == 2, "version of the page"
    for _ in range(page.varint()):
        page.varint(), page.read("QQB")  # key, box, children
        pages.append(page.reference())
        lods.append(page.varint())
        page.varint()  # number of far LODs
        for _ in range(lods[-1]):
            payloads.append(page.reference())
            for _ in range(3 if payloads[-1] else 0):
                page.varint()  # triangles, vertices, locked
            page.read("ff")  # errors
    assert page.at == len(data), "bytes after the page"
    return pages, payloads, lods[0]


def tile_references(data):
    """Returns the tiles to which a texture set refers."""
    textures, tiles = Bytes(data), []
    for _ in range(textures.read("BddiI")[-1]):
        textures.read(f"{textures.read('H')}s")  # the image's name
        width, height = textures.read("II")
        levels = []
        while width and (not levels or levels[-1] > 1):
            across, down = (-(-max(1, -(-size >> len(levels))) // INNER_TEXELS) for size in (width, height))
            levels.append(across * down)
        tiles += [Ref(*textures.read("II16s")) for _ in range(sum(levels))]
    assert textures.at == len(data), "bytes after the texture set"
    return tiles


def to_ref(message):
    digest = message.Digest()._tab  # a struct of 16 bytes, which the code of flatc 2.0 can read only byte by byte
    return Ref(message.Number(), message.Bytes(), bytes(digest.Bytes[digest.Pos : digest.Pos + 16]))


class Connection:
    def __init__(self, address):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host.strip("[]"), int(port)), timeout=300)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # sends small frames at once
        self.input, self.credited = self.socket.makefile("rb"), 0

    def close(self):
        self.input.close()
        self.socket.close()

    def send(self, name, call=0, **fields):
        message, builder = getattr(wire, name + "T")(), flatbuffers.Builder(1024)
        vars(message).update(fields)
        builder.Finish(message.Pack(builder))
        self.socket.sendall(HEADER.pack(len(builder.Output()), TYPES[name], 0, 0, call) + builder.Output())

    def open(self, model, token=""):
        """Sends Hello and Open together. Returns Opened, and the largest number of open requests."""
        self.send("Hello", 1, minVersion=VERSION, maxVersion=VERSION, token=token, program="read_model.py")
        self.send("Open", 2, model=model)
        (name, call, welcome), (also, follows, opened) = self.receive(), self.receive()
        assert (name, call, welcome.Version(), also, follows) == ("Welcome", 1, VERSION, "Opened", 2)
        return opened, welcome.MaxOpenRequests()

    def receive(self):
        """Returns the next frame, except Pongs: its type, its call id, and its message, or the raw body of a Blob."""
        while True:
            size, kind, flags, zero, call = HEADER.unpack(self.input.read(HEADER.size))
            assert size <= MAX_BODY and zero == 0 and flags & ~OPTIONAL == 0, "a bad header"
            body, name = self.input.read(size), NAMES.get(kind)
            assert name or flags & OPTIONAL, f"unknown frame {kind}"
            if name == "Blob":
                self.credited += size
                return name, call, body
            message = getattr(wire, name).GetRootAs(body) if name else None
            if name == "Error":
                sys.exit(f"the server says: {message.Message().decode()} (code {message.Code()})")
            if name == "Ping":
                self.send("Pong", call, payload=message.Payload())
            elif name not in (None, "GoAway", "ModelReplaced", "Pong"):
                return name, call, message


class Reader:
    """Requests all blobs to which received blobs refer. Always has as many open requests as allowed, and leaves the order to
    the server."""

    def __init__(self, connection, opened, max_requests):
        self.connection, self.handle, self.max_requests = connection, opened.Handle(), max_requests
        self.counts = dict(pages=0, payloads=0, textures=0, tiles=0, blobs=0, bytes=0)
        root = to_ref(opened.Summary().RootPage())
        self.wanted, self.open, self.seen = collections.deque(), {0: ("pages", root, bytearray())}, {root.number}
        self.want("textures", [to_ref(opened.Summary().Textures())] if opened.Summary().Textures() else [])

    def want(self, kind, references):
        for reference in references:
            if reference and reference.number not in self.seen:
                self.seen.add(reference.number)
                self.wanted.append((kind, reference, bytearray()))

    def request(self):
        changes = []
        while self.wanted and len(self.open) < self.max_requests and len(changes) < MAX_CHANGES:
            changes.append(wire.RequestChangeT())
            changes[-1].request = changes[-1].blob = self.wanted[0][1].number
            self.open[changes[-1].request] = self.wanted.popleft()
        if changes:
            self.connection.send("Requests", 3, handle=self.handle, changes=changes)

    def complete(self, request, kind, reference, data):
        assert hashlib.sha256(data).digest()[:16] == reference.name, f"blob {reference.number} has another name"
        for count, more in ((kind, 1), ("blobs", 1), ("bytes", len(data))):
            self.counts[count] += more
        if kind == "textures":
            self.want("tiles", tile_references(data))
        if kind == "pages":
            pages, payloads, lods = page_references(data)
            coarsest = payloads[lods - 1]
            if request == 0 and coarsest:  # the server sends this blob without a request too
                self.open[0] = ("payloads", coarsest, bytearray())
                self.seen.add(coarsest.number)
            self.want("pages", pages)
            self.want("payloads", payloads)

    def chunk(self, body):
        request, total, offset = BLOB.unpack_from(body)
        kind, reference, data = self.open[request]
        assert offset == len(data) and total == reference.bytes, "a chunk out of order, or not the size that was announced"
        data += body[BLOB.size :]
        assert len(data) <= total, "more than was announced"
        if len(data) == total:
            del self.open[request]
            self.complete(request, kind, reference, data)

    def run(self):
        while self.open or self.wanted:
            name, _, body = self.connection.receive()
            assert name == "Blob", name
            self.chunk(body)
            self.connection.send("Credit", grantedBytes=self.connection.credited + WINDOW)
            self.request()
        return self.counts


if __name__ == "__main__":
    connection = Connection(sys.argv[1])
    print(json.dumps(Reader(connection, *connection.open(*sys.argv[2:])).run()))
