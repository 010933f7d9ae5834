#!/usr/bin/python3
"""Opens a model over COUNT connections, which then stay idle: idle_clients.py HOST:PORT MODEL COUNT [tls]

Prints a line when all connections are open, and keeps them open until its stdin ends. tests/bench/bench_serving.py runs this
script. It has the same requirements as read_model.py.
"""
import resource
import ssl
import sys

from read_model import Connection


class TlsConnection(Connection):
    """A TLS connection that accepts any certificate."""

    def __init__(self, address):
        super().__init__(address)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
        self.input.close()
        self.socket = context.wrap_socket(self.socket)
        self.input = self.socket.makefile("rb")


def main():
    address, model, count, *tls = sys.argv[1:]
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    connections = []
    for _ in range(int(count)):
        connections.append((TlsConnection if tls else Connection)(address))
        connections[-1].open(model)
    print("ready", flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main()
