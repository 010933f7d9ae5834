#!/usr/bin/python3
"""Measures the latency of single requests, one after the other: request_times.py HOST:PORT MODEL FIRST LAST COUNT

Prints one JSON object. tests/bench/bench_serving.py runs this script. It has the same requirements as read_model.py.
"""
import json
import random
import statistics
import sys
import time

from urgent_request import VISIBLE, Client


def main():
    address, model, first, last, count = sys.argv[1:]
    random.seed(1)
    client, times_ms = Client(address, model, int(first), int(last)), []
    for _ in range(int(count)):
        asked = time.monotonic()
        request = client.request(VISIBLE, 1)
        while client.take() != request:
            pass
        times_ms.append(1000 * (time.monotonic() - asked))
    print(json.dumps(dict(median_ms=statistics.median(times_ms), p99_ms=statistics.quantiles(times_ms, n=100)[98])))


if __name__ == "__main__":
    main()
