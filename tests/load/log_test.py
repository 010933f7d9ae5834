#!/usr/bin/python3
"""Tests of the log of lodestreamd serve: its lines, its secrets, and readers that stop reading: log_test.py BIN_DIR MODELS_DIR
SOURCE_DIR"""
import contextlib
import json
import os
import shutil
import signal
import socket
import tempfile
import unittest

from daemon import STORE, Daemon, refusal
from processes import eventually
from read_model import HEADER, VERSION, Connection, Reader


class LogTest(unittest.TestCase):
    @contextlib.contextmanager
    def log(self):
        """Returns a file for the server's log, and a function that returns the complete lines in it."""
        with tempfile.NamedTemporaryFile("a") as file:
            def said():
                with open(file.name) as written:
                    return [line for line in written.readlines() if line.endswith("\n")]

            yield file, said


class Log(LogTest):
    def descriptors(self):
        """Yields pairs of descriptors, for reading and for writing, of each kind of file that a log may use."""
        yield os.pipe()
        reader, writer = socket.socketpair()
        yield reader.detach(), writer.detach()

    def expect_served_and_counted(self, daemon):
        for _ in range(30):  # each connection causes a line
            with contextlib.closing(daemon.open()[0]):
                pass
        eventually(lambda: daemon.metric("lodestream_log_lines_dropped_total") >= 10)
        self.assertGreater(daemon.read_whole()["payloads"], 20)

    def test_loses_only_lines_if_its_reader_is_gone(self):
        for reader, writer in self.descriptors():
            with self.subTest(writer=writer), Daemon(STORE, stderr=writer) as daemon:
                os.close(writer)
                os.close(reader)
                self.expect_served_and_counted(daemon)

    def test_loses_only_lines_if_its_reader_stalls(self):
        for reader, writer in self.descriptors():
            os.set_blocking(writer, False)
            with contextlib.suppress(BlockingIOError):
                while True:
                    os.write(writer, b"x" * 4096)
            os.set_blocking(writer, True)
            with self.subTest(writer=writer), Daemon(STORE, stderr=writer) as daemon:
                os.close(writer)
                self.expect_served_and_counted(daemon)
            os.close(reader)

    def test_records_the_end_and_the_bytes_of_each_connection(self):
        with self.log() as (log, said), Daemon(STORE, "--log-json", "--max-connections", "1", stderr=log) as daemon:
            with contextlib.closing(Connection(daemon.address)) as connection:
                self.assertEqual(refusal(daemon.address).Code(), 7)
                eventually(lambda: self.last(said, "refused", "connections"))
                read = Reader(connection, *connection.open("painted")).run()
            end = eventually(lambda: self.last(said, "connection", "client"))
            self.assertEqual(end["blobs"], read["blobs"])
            self.assertGreater(end["bytes"], read["bytes"])

    def test_distinguishes_a_wrong_token_from_other_mistakes(self):
        with self.log() as (log, said), tempfile.NamedTemporaryFile("w") as tokens:
            print("right never *", file=tokens, flush=True)
            with Daemon(STORE, "--log-json", "--token-file", tokens.name, stderr=log) as daemon:
                for kind, token, more in (("unauthorized", "wrong", b""), ("mistake", "right", b"x" * HEADER.size)):
                    with contextlib.closing(Connection(daemon.address)) as connection:
                        connection.send("Hello", 1, minVersion=VERSION, maxVersion=VERSION, token=token)
                        connection.socket.sendall(more)
                        with self.assertRaises(SystemExit):  # the server answers with an Error
                            while True:
                                connection.receive()
                    eventually(lambda: self.last(said, kind, "mistake"))

    def last(self, said, kind, reason):
        """Returns the last line if it has this kind and reason."""
        line = json.loads((said() or ["{}"])[-1])
        return line if (line.get("kind"), line.get("reason")) == (kind, reason) else None


class Secrets(LogTest):
    """No line of the log and no Error contains a token or a folder of the machine, whatever fails."""

    HIDDEN = ("hushhush", "nowhere")

    def wrong(self, daemon):
        """Makes all kinds of mistakes against a server. Returns the server's answers."""
        for token in ("", "hushhush-wrong", "hushhush-old"):
            with contextlib.closing(Connection(daemon.address)) as connection:
                yield self.error(connection, lambda: connection.open("changing", token))
        for model in ("none", "../nowhere/changing"):
            with contextlib.closing(Connection(daemon.address)) as connection:
                yield self.error(connection, lambda: connection.open(model, "hushhush-one"))
        with contextlib.closing(Connection(daemon.address)) as connection:
            connection.socket.sendall(HEADER.pack(20, 1, 0, 0, 1) + b"hushhush-one hushhus")
            yield self.error(connection, connection.receive)
        with contextlib.closing(Connection(daemon.address)) as connection:
            yield self.error(connection, Reader(connection, *connection.open("changing", "hushhush-one")).run)

    def error(self, connection, action):
        with self.assertRaises(SystemExit) as said:
            action()
        return str(said.exception)

    def expect_kept(self, *arguments):
        with tempfile.TemporaryDirectory(prefix="nowhere ") as folder, self.log() as (log, told):
            models, tokens = (os.path.join(folder, name) for name in ("models", "tokens"))
            store = os.path.join(models, "changing.lode")
            os.mkdir(models)
            shutil.copy(STORE, store)
            with open(tokens, "w") as file:
                file.write("hushhush-one never *\nhushhush-old 2020-01-31T12:00:00Z *\n")
            with Daemon(models, "--token-file", tokens, *arguments, stderr=log) as daemon:
                with open(store, "r+b") as file:
                    file.write(bytes(os.path.getsize(store)))
                said = list(self.wrong(daemon))
                with open(tokens, "w") as file:
                    file.write("hushhush-one sometimes *\n")
                os.rename(store, os.path.join(models, "other.lode"))
                daemon.process.send_signal(signal.SIGHUP)
                eventually(lambda: "tokens could not" in "".join(told()))
                shutil.rmtree(models)
                daemon.process.send_signal(signal.SIGHUP)
                eventually(lambda: "stores could not" in "".join(told()))
            for line in (*said, *told()):
                for secret in self.HIDDEN:
                    self.assertNotIn(secret, line.replace("'../nowhere/changing'", ""))

    def test_appear_in_no_log_and_no_error(self):
        for arguments in ((), ("--log-json",)):
            with self.subTest(arguments=arguments):
                self.expect_kept(*arguments)


if __name__ == "__main__":
    unittest.main()
