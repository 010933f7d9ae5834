#!/usr/bin/python3
"""Measures the latency of an urgent request behind a queue of others: urgent_request.py HOST:PORT MODEL FIRST LAST COUNT

Prefetches the blobs FIRST to LAST again and again, with a window of 96 KB. From time to time, requests one blob as visible.
Prints one JSON object. tests/bench/bench_serving.py runs this script. It has the same requirements as read_model.py.
"""
import json
import random
import statistics
import sys
import time

import lodestream_generated as wire
from read_model import BLOB, Connection

WINDOW, OPEN_PREFETCHES, VISIBLE, PREFETCH = 96 << 10, 64, 0, 2


class Client:
    def __init__(self, address, model, first, last):
        self.first, self.last, self.next_request = first, last, 1
        self.connection = Connection(address)
        opened, _ = self.connection.open(model)
        self.connection.send("Credit", grantedBytes=WINDOW)
        self.handle, self.open = opened.Handle(), set()

    def request(self, request_class, count):
        changes = []
        for _ in range(count):
            change = wire.RequestChangeT()
            change.request, change.requestClass, change.priorityPx = self.next_request, request_class, 1.0
            change.blob = random.randint(self.first, self.last)
            changes.append(change)
            self.open.add(self.next_request)
            self.next_request += 1
        if changes:
            self.connection.send("Requests", 3, handle=self.handle, changes=changes)
        return self.next_request - 1

    def take(self):
        """Reads the next chunk. Returns the number of the request that the chunk ends, or None."""
        _, _, body = self.connection.receive()
        request, total, offset = BLOB.unpack_from(body)
        self.connection.send("Credit", grantedBytes=self.connection.credited + WINDOW)
        if offset + len(body) - BLOB.size < total:
            return None
        self.open.discard(request)
        return request

    def flow(self, until):
        """Receives prefetched blobs until a request has ended (an int: its number) or until a time (a float)."""
        while True:
            self.request(PREFETCH, max(0, OPEN_PREFETCHES - len(self.open)))
            ended = self.take()
            if ended == until or (isinstance(until, float) and time.monotonic() >= until):
                return


def main():
    address, model, first, last, count = sys.argv[1:]
    random.seed(1)
    client, times_ms = Client(address, model, int(first), int(last)), []
    client.flow(time.monotonic() + 3.0)
    start, taken = time.monotonic(), client.connection.credited
    for _ in range(int(count)):
        client.flow(time.monotonic() + random.uniform(0.2, 0.6))
        asked = time.monotonic()
        client.flow(client.request(VISIBLE, 1))
        times_ms.append(1000 * (time.monotonic() - asked))
    mbit_s = (client.connection.credited - taken) * 8e-6 / (time.monotonic() - start)
    print(json.dumps(dict(median_ms=statistics.median(times_ms), max_ms=max(times_ms), bulk_mbit_s=mbit_s)))


if __name__ == "__main__":
    main()
