#!/usr/bin/python3
"""Reads a whole model from a server and checks the name of every blob: a client written from docs/protocol.md and
docs/store-format.md alone. Needs Debian's python3-flatbuffers and, on PYTHONPATH, what `flatc --python --gen-onefile
--gen-object-api proto/lodestream.fbs` makes. Prints one JSON object with what it read.

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

HEADER = struct.Struct("<IBBHI")  # body bytes, type, flags, zero, request
BLOB = struct.Struct("<III")  # wish, total, offset
TYPES = dict(Hello=1, Welcome=2, Open=5, Opened=6, Wishes=7, Credit=8, Blob=9, Cancelled=10, Error=11, GoAway=12,
             ModelReplaced=13, Ping=14, Pong=15)
OPTIONAL, MAX_BODY, WINDOW, MAX_CHANGES, INNER_TEXELS = 1, 262144, 65536, 4096, 508

Ref = collections.namedtuple("Ref", "number bytes name")


class Bytes:
    """What store-format.md calls u8, u64, varint and so on, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        piece = self.data[self.at : self.at + count]
        assert len(piece) == count, "cut off"
        self.at += count
        return piece

    def read(self, form):
        values = struct.unpack("<" + form, self.take(struct.calcsize("<" + form)))
        return values[0] if len(values) == 1 else values

    def varint(self):
        value = shift = 0
        while True:
            byte = self.read("B")
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    def reference(self):
        number = self.varint()
        return Ref(number, self.varint(), self.take(16)) if number else None


def page_nodes(data):
    """Of each node that a page holds: the reference to the page of its children or None, and those to its payloads."""
    page, nodes = Bytes(data), []
    assert page.read("B") == 1, "version of the page"
    for _ in range(page.varint()):
        page.varint(), page.read("QQB")  # key, box, children
        children, payloads = page.reference(), []
        for _ in range(page.varint()):
            payloads.append(page.reference())
            for _ in range(3 if payloads[-1] else 0):
                page.varint()  # triangles, vertices, locked
            page.read("ff")  # errors
        nodes.append((children, payloads))
    assert page.at == len(data), "bytes after the page"
    return nodes


def tile_references(data):
    """Tiles that a texture set names."""
    tiles, textures = [], Bytes(data)
    _, _, _, _, count = textures.read("BddiI")
    for _ in range(count):
        textures.take(textures.read("H"))
        width, height = textures.read("II")
        levels = []
        while width and (not levels or levels[-1] > 1):
            across, down = (-(-max(1, -(-size >> len(levels))) // INNER_TEXELS) for size in (width, height))
            levels.append(across * down)
        tiles += [Ref(*textures.read("II"), textures.take(16)) for _ in range(sum(levels))]
    assert textures.at == len(data), "bytes after the texture set"
    return tiles


class Connection:
    def __init__(self, address):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host.strip("[]"), int(port)), timeout=60)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # small frames shall not wait for acknowledgements
        self.input = self.socket.makefile("rb")
        self.credited = 0

    def close(self):
        self.input.close()
        self.socket.close()

    def send(self, name, request=0, **fields):
        message = getattr(wire, name + "T")()
        for field, value in fields.items():
            setattr(message, field, value)
        builder = flatbuffers.Builder(1024)
        builder.Finish(message.Pack(builder))
        body = builder.Output()
        self.socket.sendall(HEADER.pack(len(body), TYPES[name], 0, 0, request) + body)

    def open(self, model, token=""):
        """Hello and Open together. Returns Opened, and how many wishes may be open."""
        self.send("Hello", 1, minVersion=1, maxVersion=1, token=token, program="read_model.py")
        self.send("Open", 2, model=model)
        (name, request, welcome), (also, follows, opened) = self.receive(), self.receive()
        assert (name, request, welcome.Version(), also, follows) == ("Welcome", 1, 1, "Opened", 2)
        return opened, welcome.MaxOpenWishes()

    def receive(self):
        """The next frame that says something: its type, its request and its message, or of a Blob the raw body."""
        while True:
            size, kind, flags, zero, request = HEADER.unpack(self.input.read(HEADER.size))
            assert size <= MAX_BODY and zero == 0 and flags & ~OPTIONAL == 0, "a bad header"
            body = self.input.read(size)
            name = next((n for n, number in TYPES.items() if number == kind), None)
            if name == "Blob":
                self.credited += size
                return name, request, body
            assert name or flags & OPTIONAL, f"unknown frame {kind}"
            if not name:
                continue
            message = getattr(wire, name).GetRootAs(body)
            if name == "Ping":
                self.send("Pong", request, payload=message.Payload())
            elif name == "Error":
                sys.exit(f"the server says: {message.Message().decode()} (code {message.Code()})")
            elif name not in ("GoAway", "ModelReplaced", "Pong"):
                return name, request, message


def to_ref(message):
    name = message.Name()._tab  # a struct of 16 bytes; flatc 2.0 has no way to read them at once
    return Ref(message.Number(), message.Bytes(), bytes(name.Bytes[name.Pos : name.Pos + 16]))


class Reader:
    """Wishes for everything that it hears of, best first left to the server, as many at a time as allowed."""

    def __init__(self, connection, opened, max_wishes):
        self.connection, self.handle, self.max_wishes = connection, opened.Handle(), max_wishes
        self.wanted, self.open, self.parts, self.seen = collections.deque(), {}, {}, set()
        self.counts = dict(pages=0, payloads=0, textures=0, tiles=0, blobs=0, bytes=0)
        self.root_page = to_ref(opened.Summary().RootPage())
        self.unasked = [("pages", self.root_page)]
        self.seen.add(self.root_page.number)
        if opened.Summary().Textures():
            self.want("textures", [to_ref(opened.Summary().Textures())])

    def want(self, kind, references):
        for reference in references:
            if reference.number not in self.seen:
                self.seen.add(reference.number)
                self.wanted.append((kind, reference))

    def wish(self):
        changes = []
        while self.wanted and len(self.open) < self.max_wishes and len(changes) < MAX_CHANGES:
            kind, reference = self.wanted.popleft()
            change = wire.WishChangeT()
            change.wish, change.blob, change.priorityPx = reference.number, reference.number, 1.0
            self.open[reference.number] = (kind, reference)
            changes.append(change)
        if changes:
            self.connection.send("Wishes", 3, handle=self.handle, changes=changes)

    def complete(self, kind, reference, data):
        assert len(data) == reference.bytes, "not the size that was announced"
        assert hashlib.sha256(data).digest()[:16] == reference.name, f"blob {reference.number} has another name"
        self.counts[kind] += 1
        self.counts["blobs"] += 1
        self.counts["bytes"] += len(data)
        if kind == "textures":
            self.want("tiles", tile_references(data))
        if kind == "pages":
            nodes = page_nodes(data)
            if reference == self.root_page and nodes[0][1][-1]:
                self.unasked.append(("payloads", nodes[0][1][-1]))
                self.seen.add(nodes[0][1][-1].number)
            self.want("pages", [children for children, _ in nodes if children])
            self.want("payloads", [payload for _, payloads in nodes for payload in payloads if payload])

    def chunk(self, body):
        wish, total, offset = BLOB.unpack_from(body)
        data = self.parts.setdefault(wish, bytearray())
        kind, reference = self.unasked[0] if wish == 0 else self.open[wish]
        assert offset == len(data) and total == reference.bytes, "a chunk out of order"
        data += body[BLOB.size :]
        if len(data) == total:
            (self.unasked.pop(0) if wish == 0 else self.open.pop(wish))
            self.complete(kind, reference, bytes(self.parts.pop(wish)))

    def run(self):
        while self.unasked or self.open or self.wanted:
            name, _, body = self.connection.receive()
            assert name == "Blob", name
            self.chunk(body)
            self.connection.send("Credit", grantedBytes=self.connection.credited + WINDOW)
            self.wish()
        return self.counts


def main():
    connection = Connection(sys.argv[1])
    print(json.dumps(Reader(connection, *connection.open(*sys.argv[2:])).run()))


if __name__ == "__main__":
    main()
