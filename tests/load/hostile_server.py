"""Hostile servers: each forwards the frames of a sound lodestreamd until it misbehaves."""
import contextlib
import hashlib
import itertools
import socket
import struct
import threading
import time

import flatbuffers
import lodestream_generated as wire
from read_model import BLOB, HEADER, MAX_BODY, TYPES

MODELS, LIMIT, NOT_READY = 4, 7, 9  # a type of frames, and codes of Errors
FLOOD_BYTES = 1 << 18  # of one write


def frame(name, call=0, **fields):
    message, builder = getattr(wire, name + "T")(), flatbuffers.Builder(64)
    vars(message).update(fields)
    builder.Finish(message.Pack(builder))
    return raw_frame(TYPES[name], builder.Output(), call)


def raw_frame(kind, body, call=0):
    return HEADER.pack(len(body), kind, 0, 0, call) + body


def chunk(request, total, offset, data):
    return raw_frame(TYPES["Blob"], BLOB.pack(request, total, offset) + data)


def flood(piece):
    """Returns a behaviour that sends a piece for ever after the first picture, and reads nothing."""
    def behave(client, sound):
        sound.forward_first_picture(client)
        many = piece * (FLOOD_BYTES // len(piece) + 1)
        while True:
            client.sendall(many)
    return behave


def flood_and_read(piece):
    """Returns a behaviour like flood() that reads what the client sends."""
    def behave(client, sound):
        sound.forward_first_picture(client)
        threading.Thread(target=swallow, args=[client], daemon=True).start()
        many = piece * (FLOOD_BYTES // len(piece) + 1)
        while True:
            client.sendall(many)
    return behave


def say(piece):
    """Returns a behaviour that sends one piece after the first picture, then nothing more."""
    def behave(client, sound):
        sound.forward_first_picture(client)
        client.sendall(piece)
        swallow(client)
    return behave


def swallow(client):
    with contextlib.suppress(OSError):
        while client.recv(1 << 16):
            pass


def never_read(client, sound):
    """Forwards what the sound server sends, and reads nothing from the client."""
    for piece in sound.frames():
        client.sendall(piece)
    time.sleep(3600)


def change(edit):
    """Returns a behaviour that passes every frame of the sound server through `edit`."""
    def behave(client, sound):
        sound.follow(client)
        for piece in sound.frames():
            client.sendall(edit(piece))
    return behave


def is_blob(piece):
    return piece[4] == TYPES["Blob"]


def flip(piece):
    """Damages a blob's last byte."""
    return piece[:-1] + bytes([piece[-1] ^ 1]) if is_blob(piece) else piece


def lengthen(piece):
    """Announces a blob of another size."""
    if not is_blob(piece):
        return piece
    request, total, offset = BLOB.unpack_from(piece, HEADER.size)
    return piece[:HEADER.size] + BLOB.pack(request, total + 1, offset) + piece[HEADER.size + BLOB.size:]


def overcount(piece):
    """Announces as many open requests as the field holds."""
    if piece[4] == TYPES["Welcome"]:
        welcome = wire.WelcomeT.InitFromObj(wire.Welcome.GetRootAs(piece[HEADER.size:]))
        return frame("Welcome", 1, **{**vars(welcome), "maxOpenRequests": 2**32 - 1})
    return piece


def slowly(client, sound):
    """Sends one byte at a time."""
    sound.follow(client)
    for piece in sound.frames():
        for byte in range(len(piece)):
            client.sendall(piece[byte:byte + 1])
            time.sleep(0.002)


def stop_in_a_frame(client, sound):
    """Sends half of the first frame after the first picture, then nothing more."""
    sound.follow(client)
    for piece in sound.first_picture():
        client.sendall(piece)
    for piece in sound.frames():
        client.sendall(piece[:len(piece) // 2])
        break
    time.sleep(3600)


def end_in_a_frame(client, sound):
    """Sends half of the root's page and closes."""
    for piece in sound.frames():
        client.sendall(piece[:len(piece) // 2] if is_blob(piece) else piece)
        if is_blob(piece):
            return


def keep_all_but_the_last_byte(client, sound):
    """Holds back the last byte of every blob, so that no request ends."""
    sound.follow(client)
    for piece in sound.first_picture():
        client.sendall(piece)
    for piece in sound.frames():
        if not is_blob(piece):
            client.sendall(piece)
            continue
        request, total, offset = BLOB.unpack_from(piece, HEADER.size)
        data = piece[HEADER.size + BLOB.size:]
        client.sendall(chunk(request, total, offset, data[:-1] if offset + len(data) == total else data))


def varint(number):
    return bytes([number]) if number < 128 else bytes([number % 128 + 128]) + varint(number // 128)


def digest(data):
    return hashlib.sha256(data).digest()[:16]


def giant(payload, announced_bytes):
    """Returns a behaviour that sends a page whose only node has as many triangles and vertices as the format allows."""
    def behave(client, sound):
        welcome, opened, first = itertools.islice(sound.frames(), 3)
        page = first[HEADER.size + BLOB.size:]
        box = page[3:19]  # after the version, the count of nodes and the root's key
        false = (b"\x02\x01\x01" + box + b"\x00" + varint(0) + varint(1) + varint(0) + varint(2) + varint(announced_bytes) + digest(payload)
                 + varint(1 << 20) + varint(3 << 20) + varint(0) + struct.pack("<ff", 0, 0))
        at = opened.index(digest(page))
        size = opened.index(struct.pack("<I", len(page)), at - 24)
        assert size < at + 40
        opened = opened[:size] + struct.pack("<I", len(false)) + opened[size + 4:]
        opened = opened[:at] + digest(false) + opened[at + 16:]
        client.sendall(welcome + opened + chunk(0, len(false), 0, false) + chunk(0, announced_bytes, 0, payload[:30_000]))
        swallow(client)
    return behave


PING = frame("Ping", payload=7)
BEHAVIOURS = {
    "floods Ping and reads nothing": flood(PING),
    "floods Ping and reads": flood_and_read(PING),
    "floods payloads that nobody requested": flood(chunk(999_999, 1000, 0, bytes(1000))),
    "floods the root's page": flood(chunk(0, 1000, 0, bytes(1000))),
    "floods Errors of the session": flood(frame("Error", code=LIMIT, message="full")),
    "floods Errors of requests": flood(frame("Error", code=NOT_READY, request=999_999, message="no")),
    "floods ModelReplaced": flood(frame("ModelReplaced", handle=1)),
    "floods GoAway": flood(frame("GoAway", reason="for ever")),
    "floods frames to skip": flood(HEADER.pack(1000, 99, 1, 0, 0) + bytes(1000)),
    "never reads": never_read,
    "sends a byte at a time": slowly,
    "lies about a frame's length": say(HEADER.pack(2**32 - 1, TYPES["Blob"], 0, 0, 0)),
    "announces a frame and sends none": say(HEADER.pack(MAX_BODY, TYPES["Blob"], 0, 0, 0)),
    "lies about a blob's length": change(lengthen),
    "lies about digests": change(flip),
    "lies about counts": change(overcount),
    "announces a giant mesh": giant(bytes(2700), 2700),
    "announces a giant blob": giant(bytes(2700), 128 << 20),
    "keeps the last byte of every blob": keep_all_but_the_last_byte,
    "stops in a frame": stop_in_a_frame,
    "closes in a frame": end_in_a_frame,
}


class Sound:
    """A connection to the sound server."""

    def __init__(self, address, client):
        self.socket = socket.create_connection(address, timeout=60)
        self.input = self.socket.makefile("rb")
        self.socket.sendall(client.recv(1 << 16))  # Hello with Open
        self.all = self.read()

    def read(self):
        while header := self.input.read(HEADER.size):
            yield header + self.input.read(struct.unpack_from("<I", header)[0])

    def frames(self):
        return self.all

    def first_picture(self):
        """Yields frames until the root's page and coarsest LOD are complete, or two frames of a list."""
        blobs = 0
        for piece in self.all:
            yield piece
            if is_blob(piece):
                _, total, offset = BLOB.unpack_from(piece, HEADER.size)
                blobs += offset + len(piece) - HEADER.size - BLOB.size == total
            if blobs == 2 or piece[4] == MODELS:
                return

    def forward_first_picture(self, client):
        for piece in self.first_picture():
            client.sendall(piece)

    def follow(self, client):
        """Forwards what the client sends from now on."""
        def pump():
            with contextlib.suppress(OSError):
                while some := client.recv(1 << 16):
                    self.socket.sendall(some)
        threading.Thread(target=pump, daemon=True).start()

    def close(self):
        self.input.close()
        self.socket.close()


class HostileServer:
    """Listens on loopback and misbehaves towards every connection, until the end of the `with` block."""

    def __init__(self, sound, behave):
        host, port = sound.rsplit(":", 1)
        self.sound, self.behave = (host, int(port)), behave
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.clients = []
        threading.Thread(target=self.accept, daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.listener.close()
        for client in self.clients:
            with contextlib.suppress(OSError):
                client.shutdown(socket.SHUT_RDWR)

    @property
    def address(self):
        return "127.0.0.1:%d" % self.listener.getsockname()[1]

    def accept(self):
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            self.clients.append(client)
            threading.Thread(target=self.serve, args=[client], daemon=True).start()

    def serve(self, client):
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with contextlib.suppress(OSError, struct.error), client, contextlib.closing(Sound(self.sound, client)) as sound:
            self.behave(client, sound)
