#!/usr/bin/python3
"""Measures the time to a Pong on a connection whose blobs come from a disk: pong_times.py HOST:PORT MODEL FIRST LAST SECONDS

Always has eight open requests and one unanswered Ping. Prints one JSON object. tests/bench/bench_serving.py runs this script.
It has the same requirements as read_model.py.
"""
import json
import random
import statistics
import sys
import time

import lodestream_generated as wire
from read_model import BLOB, HEADER, TYPES
from urgent_request import PREFETCH, WINDOW, Client

OPEN_REQUESTS = 8


def frames(connection):
    """Yields the types and bodies of the frames in the order of their arrival, Pongs included."""
    while True:
        size, kind, *_ = HEADER.unpack(connection.input.read(HEADER.size))
        yield kind, connection.input.read(size)


def main():
    address, model, first, last, seconds = sys.argv[1:]
    random.seed(1)
    client, times_ms, received, asked = Client(address, model, int(first), int(last)), [], 0, None
    end = time.monotonic() + float(seconds)
    for kind, body in frames(client.connection):
        if kind == TYPES["Pong"]:
            times_ms.append(1000 * (time.monotonic() - asked))
            asked = None
        elif kind == TYPES["Blob"]:
            request, total, offset = BLOB.unpack_from(body)
            received += len(body)
            client.connection.send("Credit", grantedBytes=received + WINDOW)
            if offset + len(body) - BLOB.size == total:
                client.open.discard(request)
        elif kind == TYPES["Error"]:
            sys.exit(f"the server says: {wire.Error.GetRootAs(body).Message().decode()}")
        if time.monotonic() > end:
            break
        client.request(PREFETCH, OPEN_REQUESTS - len(client.open))
        if asked is None:
            asked = time.monotonic()
            client.connection.send("Ping", 1, payload=1)
    print(json.dumps(dict(median_ms=statistics.median(times_ms), p99_ms=statistics.quantiles(times_ms, n=100)[98],
                          pongs=len(times_ms), mbyte_s=received * 1e-6 / float(seconds))))


if __name__ == "__main__":
    main()
