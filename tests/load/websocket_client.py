"""A client of WebSockets (RFC 6455) for tests, and a relay that joins TCP clients to a WebSocket."""
import base64
import contextlib
import os
import random
import socket
import struct
import threading

BINARY, TEXT, CLOSE, PING, PONG = 2, 1, 8, 9, 10


def masked(payload, mask):
    if not payload:
        return b""
    size = len(payload)
    key = int.from_bytes((mask * (size // 4 + 1))[:size], "big")
    return (int.from_bytes(payload, "big") ^ key).to_bytes(size, "big")


def frame(opcode, payload, final=True):
    """Returns a frame as a client sends it."""
    mask = os.urandom(4)
    size = len(payload)
    head = bytes([0x80 * final | opcode])
    if size < 126:
        head += bytes([0x80 | size])
    else:
        head += b"\xfe" + struct.pack(">H", size) if size < 65536 else b"\xff" + struct.pack(">Q", size)
    return head + mask + masked(payload, mask)


class WebSocket:
    """The client's end of a WebSocket. With `seed`, splits what it sends at random into frames and messages."""

    def __init__(self, address, path="/ws", seed=None, tls=None, **fields):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host.strip("[]"), int(port)), timeout=120)
        if tls:
            self.socket = tls.wrap_socket(self.socket, server_hostname=host)
        self.input = self.socket.makefile("rb")
        self.chance = random.Random(seed) if seed is not None else None
        self.fields = dict(Host=address, Upgrade="websocket", Connection="Upgrade", Sec_WebSocket_Version="13",
                           Sec_WebSocket_Key=base64.b64encode(os.urandom(16)).decode())
        self.fields.update(fields)
        lines = [f"{name.replace('_', '-')}: {value}" for name, value in self.fields.items() if value is not None]
        self.socket.sendall("\r\n".join([f"GET {path} HTTP/1.1", *lines, "", ""]).encode())
        self.status = int(self.input.readline().split()[1])
        self.head = {}
        while (line := self.input.readline()) not in (b"\r\n", b""):
            name, value = line.decode().split(":", 1)
            self.head[name.lower()] = value.strip()
        self.answers, self.payload, self.closed_with = [], b"", None

    def close(self):
        self.input.close()
        self.socket.close()

    def sendall(self, data):
        if self.chance is None:
            return self.socket.sendall(frame(BINARY, data))
        sent = b""
        while data:
            count = self.chance.choice((1, 5, 125, 126, 70000))
            parts, data = [data[:count // 2], data[count // 2:count]], data[count:]
            sent += frame(BINARY, parts[0], False) + frame(PING, b"p") + frame(0, parts[1])
        self.socket.sendall(sent)

    def receive(self):
        """Returns the opcode and the payload of the next frame, or nothing at the end."""
        head = self.input.read(2)
        if len(head) < 2:
            return None
        assert head[0] & 0x70 == 0 and head[1] & 0x80 == 0, "a server masks nothing and agrees on no extension"
        size = head[1]
        if size > 125:
            size = int.from_bytes(self.input.read(2 if size == 126 else 8), "big")
        return head[0] & 15, self.input.read(size)

    def recv(self, _=0):
        """Returns the payload of the next binary message, or nothing at the end. Answers of other kinds are in `answers`."""
        while found := self.receive():
            opcode, payload = found
            if opcode == BINARY:
                return payload
            self.answers.append((opcode, payload))
            if opcode == CLOSE:
                self.closed_with = payload
        return b""

    def read(self, size):
        """Returns bytes of the joined messages, fewer only at the end."""
        while len(self.payload) < size and (part := self.recv()):
            self.payload += part
        data, self.payload = self.payload[:size], self.payload[size:]
        return data


class Relay:
    """Listens for TCP clients and joins each to a WebSocket of its own."""

    def __init__(self, address, seed=None, tls=None):
        self.open = lambda: WebSocket(address, seed=seed, tls=tls)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self.accept, daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.listener.close()

    def accept(self):
        with contextlib.suppress(OSError):
            while True:
                threading.Thread(target=self.join, args=(self.listener.accept()[0],), daemon=True).start()

    def join(self, client):
        with contextlib.closing(client), contextlib.closing(self.open()) as server, contextlib.suppress(OSError, ValueError):
            back = threading.Thread(target=self.copy, args=(server.recv, client), daemon=True)
            back.start()
            self.copy(lambda: client.recv(65536), server)
            server.socket.sendall(frame(CLOSE, b"\x03\xe8"))
            back.join()

    @staticmethod
    def copy(receive, to):
        with contextlib.suppress(OSError, ValueError):
            while part := receive():
                to.sendall(part)
            if isinstance(to, socket.socket):
                to.shutdown(socket.SHUT_WR)
