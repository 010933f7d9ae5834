#!/usr/bin/python3
"""Sends single requests at regular times, and measures their latency:

    probe.py HOST:PORT MODEL LAST_BLOB SECONDS [--every S] [--open N] [--ca-file F] [--seed S]

Requests a random blob from 1 to LAST_BLOB, as visible, every 50 ms or every --every seconds. The latency of a request counts
from its intended time, even if an earlier request delayed it. Reconnects after each failure. With --open N, the probe is greedy
instead: it always has N open requests, and an endless window. With --ca-file, the probe uses TLS and trusts these authorities.
Prints one JSON object. Has the same requirements as read_model.py.
"""
import argparse
import contextlib
import json
import random
import ssl
import struct
import time

import lodestream_generated as wire
from read_model import BLOB, Connection

RETRY_S, ENDLESS = 0.1, 1 << 60
GONE = (OSError, SystemExit, AssertionError, struct.error)  # a refusal, a reset, a cut, an Error, GoAway or the end


class TlsConnection(Connection):
    def __init__(self, address, authorities):
        super().__init__(address)
        self.input.close()
        context = ssl.create_default_context(cafile=authorities)
        self.socket = context.wrap_socket(self.socket, server_hostname=address.rsplit(":", 1)[0])
        self.input = self.socket.makefile("rb")


class Probe:
    def __init__(self, address, model, last_blob, authorities=None):
        self.address, self.model, self.last_blob, self.authorities = address, model, last_blob, authorities
        self.connection, self.request, self.bytes = None, 0, 0

    def close(self):
        if self.connection:
            with contextlib.suppress(OSError):
                self.connection.close()
        self.connection = None

    def connect(self):
        connection = TlsConnection(self.address, self.authorities) if self.authorities else Connection(self.address)
        connection.socket.settimeout(2)
        self.connection = connection
        connection.open(self.model)
        connection.send("Credit", grantedBytes=ENDLESS)

    def ask(self, count=1):
        changes = [wire.RequestChangeT() for _ in range(count)]
        for change in changes:
            self.request += 1
            change.request, change.blob, change.priorityPx = self.request, random.randint(1, self.last_blob), 1.0
        self.connection.send("Requests", 3, handle=1, changes=changes)

    def take(self):
        """Reads the next chunk. Returns the number of the request that the chunk ends, or 0."""
        _, _, body = self.connection.receive()
        request, total, offset = BLOB.unpack_from(body)
        self.bytes += len(body) - BLOB.size
        return request if offset + len(body) - BLOB.size == total else 0

    def one(self):
        if not self.connection:
            self.connect()
        self.ask()
        while self.take() != self.request:
            pass


def until_it_comes(probe, end):
    """Waits for the answer, and repeats the request if the connection fails. Returns the number of failures, and whether the
    answer arrived."""
    failed = 0
    while time.monotonic() < end:
        try:
            probe.one()
            return failed, True
        except GONE:
            probe.close()
            failed += 1
            time.sleep(RETRY_S)
    return failed, False


def politely(probe, seconds, every):
    """Returns one pair per request: its intended time in seconds since the start, and its latency in milliseconds."""
    start = time.monotonic()
    end, times, failed, count = start + seconds, [], 0, 0
    while (due := start + count * every) < end:
        time.sleep(max(0, due - time.monotonic()))
        more, came = until_it_comes(probe, end)
        failed += more
        if came:
            times.append((round(due - start, 3), round(1000 * (time.monotonic() - due), 3)))
        count += 1
    return dict(times=times, failed=failed, unanswered=count - len(times))


def greedily(probe, seconds, requests):
    end = time.monotonic() + seconds
    probe.connect()
    probe.ask(requests)
    with contextlib.suppress(GONE):
        while time.monotonic() < end:
            if probe.take():
                probe.ask()
    return dict(bytes=probe.bytes, seconds=seconds)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("address")
    parser.add_argument("model")
    parser.add_argument("last_blob", type=int)
    parser.add_argument("seconds", type=float)
    parser.add_argument("--every", type=float, default=0.05)
    parser.add_argument("--open", type=int)
    parser.add_argument("--ca-file")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random.seed(options.seed)
    with contextlib.closing(Probe(options.address, options.model, options.last_blob, options.ca_file)) as probe:
        print(json.dumps(greedily(probe, options.seconds, options.open) if options.open else politely(probe, options.seconds, options.every)))


if __name__ == "__main__":
    main()
