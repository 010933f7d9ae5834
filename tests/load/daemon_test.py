#!/usr/bin/python3
"""Tests of lodestreamd in its surroundings: limits of open files, the service manager, signals under load.

    daemon_test.py BIN_DIR MODELS_DIR SOURCE_DIR
"""
import contextlib
import fcntl
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import termios
import threading
import time
import unittest

from daemon import BIN, MODELS, SOURCE, STORE, Daemon, refusal, requests
from idle_clients import TlsConnection
from processes import eventually, running, self_signed
from read_model import BLOB, DAMAGED_STORE, HEADER, LIMIT, NO_SUCH_MODEL, Connection


def tls_options(folder):
    made = self_signed(pathlib.Path(folder))
    return "--tls-cert", str(made / "cert.pem"), "--tls-key", str(made / "key.pem")


class OpenFiles(unittest.TestCase):
    def start(self, log, *arguments):
        few = lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (800, 800))
        return Daemon(STORE, *arguments, stderr=log, preexec_fn=few)

    def said(self, log):
        log.seek(0)
        return log.read()

    def test_limit_on_connections_is_announced_at_start_and_holds(self):
        with tempfile.TemporaryFile("w+") as log, contextlib.ExitStack() as clients:
            with self.start(log, "--max-connections", "1000") as daemon:
                eventually(lambda: "allows fewer connections" in self.said(log))
                possible = int(re.search(r"possible=(\d+)", self.said(log)).group(1))
                for _ in range(possible):
                    clients.enter_context(contextlib.closing(daemon.open()[0]))
                for _ in range(300):
                    self.assertEqual(refusal(daemon.address).Code(), LIMIT)
                self.assertEqual(daemon.metric('lodestream_connections_refused_total{reason="descriptors"}'), 0)

    def test_limit_is_not_announced_if_it_suffices(self):
        with tempfile.TemporaryFile("w+") as log:
            with self.start(log, "--max-connections", "100"):
                pass
            self.assertNotIn("fewer", self.said(log))


class ServiceManager(unittest.TestCase):
    def test_is_notified_of_ready_reload_and_stop(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in (os.path.join(folder, "notify"), f"\0lodestream-test-{os.getpid()}"):
                with self.subTest(name=name), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
                    manager.bind(name)
                    manager.settimeout(120)
                    hear = lambda: manager.recv(4096).decode()
                    with Daemon(STORE, env=dict(os.environ, NOTIFY_SOCKET=name.replace("\0", "@"))) as daemon:
                        self.assertEqual(hear(), "READY=1")
                        before = time.monotonic_ns() // 1000
                        daemon.process.send_signal(signal.SIGHUP)
                        reloading, since = hear().split("\n")
                        self.assertEqual(reloading, "RELOADING=1")
                        self.assertTrue(before <= int(since.removeprefix("MONOTONIC_USEC=")) <= time.monotonic_ns() // 1000)
                        self.assertEqual(hear(), "READY=1")
                    self.assertEqual(hear(), "STOPPING=1")

    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd-analyze comes with Debian's package systemd")
    def test_accepts_the_installed_unit_and_the_drop_in(self):
        packaging = os.path.join(SOURCE, "cmake", "packaging")
        with tempfile.TemporaryDirectory() as folder:
            unit = os.path.join(folder, "lodestreamd.service")
            os.mkdir(unit + ".d")
            for name, path in (("lodestreamd.service", unit), ("public.conf", unit + ".d/public.conf")):
                with open(os.path.join(packaging, name)) as source, open(path, "w") as file:
                    file.write(source.read().replace("ExecStart=lodestreamd", "ExecStart=" + os.path.join(BIN, "lodestreamd")))
                with self.subTest(name):
                    done = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True)
                    self.assertEqual((done.returncode, done.stderr), (0, ""))
                    done = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=20", unit],
                                          capture_output=True, text=True)
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_hands_over_the_listening_socket(self):
        with socket.create_server(("127.0.0.1", 0)) as listening:
            move = f"exec 3<&{listening.fileno()}; LISTEN_PID=$$ LISTEN_FDS=1"
            with Daemon(STORE, shell=move, pass_fds=[listening.fileno()]) as daemon:
                self.assertEqual(daemon.address, "127.0.0.1:%d" % listening.getsockname()[1])
                self.assertGreater(daemon.read_whole()["payloads"], 20)

    def test_socket_for_another_process_is_ignored(self):
        with socket.create_server(("127.0.0.1", 0)) as listening:
            move = f"exec 3<&{listening.fileno()}; LISTEN_PID=1 LISTEN_FDS=1"
            with Daemon(STORE, shell=move, pass_fds=[listening.fileno()]) as daemon:
                self.assertNotEqual(daemon.address, "127.0.0.1:%d" % listening.getsockname()[1])

    def test_gets_one_line_about_a_bad_socket(self):
        udp, deaf = (socket.socket(socket.AF_INET, kind) for kind in (socket.SOCK_DGRAM, socket.SOCK_STREAM))
        with tempfile.TemporaryFile() as no_socket, udp, deaf:
            for given, count, named in ((no_socket, 1, "listen on TCP"), (udp, 1, "listen on TCP"), (deaf, 1, "listen on TCP"),
                                        (udp, 2, "2 sockets")):
                with self.subTest(named=named, given=given):
                    done = subprocess.run(
                        ["sh", "-c", f'exec 3<&{given.fileno()}; LISTEN_PID=$$ LISTEN_FDS={count} exec "$0" "$@"',
                         os.path.join(BIN, "lodestreamd"), "serve", STORE],
                        pass_fds=[given.fileno()], capture_output=True, text=True)
                    self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1))
                    self.assertIn(named, done.stderr)

    def test_sees_not_ready_during_the_drain_delay_while_connections_work(self):
        with Daemon(STORE, "--drain-delay", "2") as daemon:
            self.assertEqual(daemon.ask("/readyz")[0], 200)
            daemon.process.send_signal(signal.SIGTERM)
            eventually(lambda: daemon.ask("/readyz")[0] == 503)
            self.assertEqual(daemon.ask("/healthz")[0], 200)
            self.assertGreater(daemon.read_whole()["payloads"], 20)
            self.assertIsNone(daemon.process.poll())

    def test_may_send_signals_until_the_server_has_ended(self):
        for again in (signal.SIGTERM, signal.SIGHUP):
            with self.subTest(again=again), Daemon(STORE, stderr=subprocess.DEVNULL) as daemon:
                daemon.process.send_signal(signal.SIGTERM)
                while daemon.process.poll() is None:
                    daemon.process.send_signal(again)
                self.assertEqual(daemon.process.returncode, 0)

    def pipe_of_tokens(self, folder):
        """Puts a pipe in place of a file. A reader of the pipe waits, as for a disk that does not answer."""
        tokens = os.path.join(folder, "tokens")
        with contextlib.suppress(FileNotFoundError):
            os.remove(tokens)
        os.mkfifo(tokens)
        return tokens

    def once_it_is_read(self, pipe):
        writers = []

        def opened():
            with contextlib.suppress(OSError):
                writers.append(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK))
            return writers

        eventually(opened)
        return os.fdopen(writers[0], "w")

    def test_stops_the_server_while_a_reload_waits_for_the_disk(self):
        with tempfile.TemporaryDirectory() as folder:
            tokens = os.path.join(folder, "tokens")
            pathlib.Path(tokens).write_text("one never *\n")
            with Daemon(STORE, "--token-file", tokens, stderr=subprocess.DEVNULL) as daemon:
                self.pipe_of_tokens(folder)
                daemon.process.send_signal(signal.SIGHUP)
                with self.once_it_is_read(tokens):
                    daemon.process.send_signal(signal.SIGTERM)
                    self.assertEqual(daemon.process.wait(timeout=120), 0)

    def test_gets_a_reload_that_it_requested_before_the_server_was_ready(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy(STORE, os.path.join(folder, "first.lode"))
            tokens, log = self.pipe_of_tokens(folder), os.path.join(folder, "log")
            command = [os.path.join(BIN, "lodestreamd"), "serve", folder, "--listen", "127.0.0.1:0", "--token-file", tokens]
            with open(log, "w") as said, running(command, stdout=subprocess.PIPE, stderr=said, text=True) as process:
                with self.once_it_is_read(tokens) as writer:  # the server has read the stores before
                    shutil.copy(STORE, os.path.join(folder, "second.lode"))
                    process.send_signal(signal.SIGHUP)
                    writer.write("one never *\n")
                self.assertIn("listen", process.stdout.readline())
                with self.once_it_is_read(tokens) as writer:
                    writer.write("one never *\n")
                eventually(lambda: re.search(r"reloaded.*models=2", pathlib.Path(log).read_text()))
                process.send_signal(signal.SIGTERM)
                self.assertEqual(process.wait(timeout=120), 0)

    def test_sees_connections_refused_after_the_drain_delay(self):
        with Daemon(STORE) as daemon, contextlib.closing(daemon.open()[0]) as connection:
            connection.send("Requests", 3, handle=1, changes=requests(4000))  # more than the window allows
            daemon.process.send_signal(signal.SIGTERM)
            eventually(lambda: self.nobody_listens(daemon.address))
            self.assertIsNone(daemon.process.poll())
            connection.close()
            self.assertEqual(daemon.process.wait(timeout=120), 0)

    def nobody_listens(self, address):
        host, port = address.rsplit(":", 1)
        with socket.socket() as client:
            return client.connect_ex((host, int(port))) != 0


class Latency(unittest.TestCase):
    """Tests the latency histograms with a client that lets its requests wait for seconds."""

    REQUESTS, HELD_S = 4000, 3.0

    def seconds(self, daemon, figure):
        return daemon.metric(f'lodestream_request_{figure}_seconds_sum{{class="visible"}}')

    def expect_told_from_the_servers(self, granted_at_first):
        with Daemon(STORE) as daemon, contextlib.closing(daemon.open()[0]) as connection:
            connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
            connection.send("Credit", grantedBytes=granted_at_first)
            connection.send("Requests", 3, handle=1, changes=requests(self.REQUESTS))
            time.sleep(self.HELD_S)
            connection.send("Credit", grantedBytes=1 << 40)
            ended = 0
            while ended < self.REQUESTS:
                request, total, offset = BLOB.unpack_from(body := connection.receive()[2])
                ended += request > 0 and offset + len(body) - BLOB.size == total
            held, queue = (self.seconds(daemon, figure) for figure in ("held", "queue"))
            self.assertGreater(held, self.REQUESTS / 2 * self.HELD_S)
            return queue / held

    def test_few_bytes_precede_an_urgent_request_if_the_client_reads_nothing(self):
        with Daemon(STORE) as daemon, contextlib.closing(daemon.open()[0]) as connection:
            connection.send("Credit", grantedBytes=1 << 40)
            connection.send("Requests", 3, handle=1, changes=requests(self.REQUESTS, request_class=2))
            sent = [0]
            while len(sent) < 20 or sent[-1] != sent[-20]:  # until the server sends nothing more
                sent.append(daemon.metric('lodestream_model_sent_bytes_total{model="painted"}'))
                time.sleep(0.01)
            connection.send("Requests", 4, handle=1, changes=requests(self.REQUESTS + 1)[-1:])
            eventually(lambda: daemon.metric('lodestream_requests_total{class="visible"}') == 1)
            before = -struct.unpack("i", fcntl.ioctl(connection.socket, termios.FIONREAD, bytes(4)))[0]  # number of bytes that
                                                                                                         # have already arrived
            while BLOB.unpack_from(body := connection.receive()[2])[0] <= self.REQUESTS:
                before += HEADER.size + len(body)
            self.assertLess(before, 96 << 10)  # megabytes, if the server did not limit the kernel's buffer

    def test_excludes_the_time_of_a_shut_window(self):
        self.assertLess(self.expect_told_from_the_servers(granted_at_first=0), 0.5)

    def test_excludes_the_time_of_a_full_link(self):
        self.assertLess(self.expect_told_from_the_servers(granted_at_first=1 << 40), 0.5)


@unittest.skipUnless(shutil.which("promtool"), "promtool comes with Debian's package prometheus")
class Metrics(unittest.TestCase):
    def test_pass_promtool_after_a_read(self):
        with Daemon(STORE) as daemon:
            daemon.read_whole()
            text = daemon.ask("/metrics")[1]
        done = subprocess.run(["promtool", "check", "metrics"], input=text, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def expect_told_as_gone_by_itself(self, client, *arguments):
        with Daemon(STORE, *arguments) as daemon:
            with contextlib.closing(client(daemon.address)) as connection:
                connection.open("painted")
            ended = lambda reason: daemon.metric(f'lodestream_connections_ended_total{{reason="{reason}"}}')
            eventually(lambda: daemon.metric("lodestream_connections") == 0)
            self.assertEqual((ended("client"), ended("broken")), (1, 0))

    def test_distinguish_clean_ends_from_broken_connections(self):
        self.expect_told_as_gone_by_itself(Connection)
        with tempfile.TemporaryDirectory() as folder:
            self.expect_told_as_gone_by_itself(TlsConnection, *tls_options(folder))


RULES = os.path.join(SOURCE, "docker", "prometheus", "rules.yml")


class OperatorsPage(unittest.TestCase):
    """docs/operations.md names exactly the options, metrics and log kinds that exist."""

    def setUp(self):
        with open(os.path.join(SOURCE, "docs", "operations.md")) as page:
            self.page = page.read()

    def options(self, command, program="lodestreamd"):
        done = subprocess.run([os.path.join(BIN, program), command, "--help"], capture_output=True, text=True, check=True)
        return set(re.findall(r"--[a-z][a-z-]+", done.stdout))

    def test_names_the_options_of_serve(self):
        named = set(re.findall(r"--[a-z][a-z-]+", self.page))
        self.assertEqual(self.options("serve") - named - {"--help", "--version"}, set())
        others = self.options("build") | self.options("export") | self.options("fetch", "lodestream")
        self.assertEqual(named - self.options("serve") - others, set())

    @unittest.skipUnless(shutil.which("promtool"), "promtool comes with Debian's package prometheus")
    def test_has_alert_rules_that_promtool_accepts(self):
        done = subprocess.run(["promtool", "check", "rules", RULES], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn(f"{pathlib.Path(RULES).read_text().count('alert:')} rules", done.stdout)

    @unittest.skipUnless(shutil.which("promtool"), "promtool comes with Debian's package prometheus")
    def test_has_alert_rules_that_pass_their_promtool_tests(self):
        done = subprocess.run(["promtool", "test", "rules", os.path.join(SOURCE, "tests", "load", "rules_test.yml")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_names_the_metrics(self):
        with tempfile.TemporaryDirectory() as folder, Daemon(STORE, "--http", "127.0.0.1:0", *tls_options(folder)) as daemon:
            there = set(re.findall(r"^# TYPE (\w+) ", daemon.ask("/metrics")[1], re.M))
        self.assertEqual(there, set(re.findall(r"lodestream_[a-z_]+", self.page)))
        in_rules = re.findall(r"lodestream_[a-z_]+", pathlib.Path(RULES).read_text())
        self.assertEqual({name.removesuffix("_bucket") for name in in_rules} - there, set())

    def test_names_the_reasons_of_refusals_and_ends(self):
        with Daemon(STORE) as daemon:
            reasons = set(re.findall(r'reason="(\w+)"', daemon.ask("/metrics")[1]))
        self.assertEqual({reason for reason in reasons if f"`{reason}`" not in self.page}, set())


class UnderLoad(unittest.TestCase):
    """Eight clients read whole models and compare every digest, while an operator changes models and tokens."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        for model in ("steady", "changing"):
            shutil.copy(STORE, self.path(model))
        self.other = os.path.join(MODELS, "gyroid.lode")
        self.stop, self.mistakes, self.reads = threading.Event(), [], {"steady": 0, "changing": 0}

    def tearDown(self):
        self.folder.cleanup()

    def path(self, model):
        return os.path.join(self.folder.name, model + ".lode")

    def read(self, daemon, model, allowed):
        while not self.stop.is_set():
            try:
                daemon.read_whole(model)
                self.reads[model] += 1
            except (SystemExit, Exception) as error:  # an Error of the server, a broken connection, or wrong bytes
                if not self.stop.is_set() and not any(text in str(error) for text in allowed):
                    self.mistakes.append(f"{model}: {error!r}")
                time.sleep(0.01)

    @contextlib.contextmanager
    def readers(self, daemon, allowed=()):
        threads = [threading.Thread(target=self.read, args=(daemon, model, texts))
                   for model, texts in (("steady", ()), ("changing", allowed)) for _ in range(4)]
        for thread in threads:
            thread.start()
        try:
            yield
        finally:
            self.stop.set()
            for thread in threads:
                thread.join()
        self.assertEqual(self.mistakes, [])

    def replace(self, model, store):
        """Replaces a store by renaming, as builds do."""
        shutil.copy(store, self.path(model) + ".new")
        os.rename(self.path(model) + ".new", self.path(model))

    def reload(self, daemon):
        before = self.reads["steady"]
        daemon.process.send_signal(signal.SIGHUP)
        eventually(lambda: self.reads["steady"] >= before + 2 or self.mistakes)

    def content(self, daemon):
        """Returns the content of the model that changes; None if the server does not have it."""
        try:
            return daemon.read_whole("changing")
        except SystemExit as said:
            self.assertIn(f"(code {NO_SUCH_MODEL})", str(said))

    def test_replaced_and_removed_stores_disturb_no_other_readers(self):
        with Daemon(STORE, self.other) as daemon:
            at_first, other = daemon.read_whole("painted"), daemon.read_whole("gyroid")
        self.assertNotEqual(at_first, other)
        with Daemon(self.folder.name, stderr=subprocess.DEVNULL) as daemon:
            with self.readers(daemon, allowed=(f"(code {NO_SUCH_MODEL})",)):
                for _ in range(4):
                    self.replace("changing", self.other)
                    self.reload(daemon)
                    eventually(lambda: self.content(daemon) == other)
                    os.remove(self.path("changing"))
                    self.reload(daemon)
                    eventually(lambda: self.content(daemon) is None)
                    self.replace("changing", STORE)
                    self.reload(daemon)
                    eventually(lambda: self.content(daemon) == at_first)
            self.assertGreater(self.reads["changing"], 0)

    def test_a_store_overwritten_in_place_is_damaged_only_for_its_readers(self):
        with Daemon(self.folder.name, stderr=subprocess.DEVNULL) as daemon:
            # A chunk that the server reads within the 20 ms between two checks of the file may be wrong. The digest shows this
            # to the client.
            with self.readers(daemon, allowed=(f"(code {DAMAGED_STORE})", "has another name")):
                with open(self.path("changing"), "r+b") as store:
                    for at in range(2000, os.path.getsize(self.path("changing")) - 2000, 5000):
                        store.seek(at)
                        store.write(b"overwritten")
                eventually(lambda: daemon.metric('lodestream_model_damaged_blobs_total{model="changing"}') > 0)
                before = self.reads["steady"]
                eventually(lambda: self.reads["steady"] >= before + 4 or self.mistakes)

    def test_server_stops_at_its_deadline_despite_a_client_that_never_reads(self):
        with Daemon(self.folder.name, "--drain-deadline", "1", stderr=subprocess.DEVNULL) as daemon:
            with self.readers(daemon), contextlib.closing(daemon.open("steady")[0]) as connection:
                connection.send("Requests", 3, handle=1, changes=requests(4000))  # more than the window allows
                eventually(lambda: self.reads["steady"] > 2)
                self.stop.set()  # from here on connections may break
                daemon.process.send_signal(signal.SIGTERM)
                self.assertEqual(daemon.process.wait(timeout=120), 0)


if __name__ == "__main__":
    unittest.main()
