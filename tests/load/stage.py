"""Parts of a load scenario: servers, a balancer, clients, figures over time, a table and a plot.

All started processes end with the scenario. All files are in a temporary folder.
"""
import contextlib
import json
import math
import os
import pathlib
import re
import signal
import statistics
import subprocess
import sys
import threading
import time
import urllib.request

from processes import cpu_seconds, free_port, start, wait_for

LOAD = pathlib.Path(__file__).resolve().parent
SAMPLE_EVERY_S = 0.25


def percentile(values, part):
    """Returns a percentile of some values; nan if there are none. part: 0 to 1."""
    ordered = sorted(values)
    return ordered[max(0, math.ceil(part * len(ordered)) - 1)] if ordered else math.nan


def parse_metrics(text):
    """Parses a server's metrics. Returns values by name without `lodestream_`, summed over labels. Omits the buckets of
    histograms."""
    figures = {}
    for name, labels, value in re.findall(r"^lodestream_(\w+)(\{.*\})? (\S+)$", text, re.M):
        if not name.endswith("_bucket"):
            figures[name] = figures.get(name, 0) + float(value)
    return figures


def rates(samples, name):
    """Returns the growth of a counter per second between samples. Falling counters count as 0, because a server has
    restarted."""
    pairs = [(a, b) for a, b in zip(samples, samples[1:]) if name in a and name in b and b["t"] > a["t"]]
    return [b["t"] for a, b in pairs], [max(0, b[name] - a[name]) / (b["t"] - a["t"]) for a, b in pairs]


class Server:
    """Runs lodestreamd serve. The ports stay the same when the server is started again."""

    def __init__(self, stage, *options, prefix=(), host="127.0.0.1", store=None):
        self.stage, self.prefix, self.host, self.options = stage, prefix, host, options
        self.store = store or stage.store
        self.listen, self.metrics = f"{host}:{free_port()}", f"{host}:{free_port()}"
        self.process = None
        self.start()

    def start(self):
        command = [*self.prefix, self.stage.bin / "lodestreamd", "serve", self.store, "--listen", self.listen, "--metrics", self.metrics,
                   "--threads", 1, "--public", "--insecure", *self.options]
        self.process = start(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        if not self.process.stdout.readline():
            sys.exit("lodestreamd did not start")

    def end(self, how=signal.SIGTERM):
        """Ends the server. Returns its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        status = self.process.wait(timeout=300)
        self.process.stdout.close()
        return status

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()

    def figures(self):
        """Returns the metrics; None if the server does not answer."""
        with contextlib.suppress(OSError), urllib.request.urlopen(f"http://{self.metrics}/metrics", timeout=2) as answer:
            return parse_metrics(answer.read().decode())

    def cpu_seconds(self):
        return cpu_seconds(self.process)


class Sampler:
    """Records the metrics of all servers, summed, four times a second during the `with`."""

    def __init__(self, servers):
        self.servers, self.samples, self.began = servers, [], time.monotonic()
        self.over, self.thread = threading.Event(), threading.Thread(target=self.run)

    def run(self):
        while not self.over.wait(SAMPLE_EVERY_S):
            sample = dict(t=time.monotonic() - self.began, answering=0)
            for figures in filter(None, (server.figures() for server in self.servers)):
                sample["answering"] += 1
                for name, value in figures.items():
                    sample[name] = sample.get(name, 0) + value
            self.samples.append(sample)

    def most(self, name):
        return max((sample.get(name, 0) for sample in self.samples), default=0)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()


class Stage:
    """The folder, programs, store and plot of a scenario. The end of the `with` ends all started processes."""

    def __init__(self, programs, folder, store=None, messages=None, short=False, seconds=None):
        """seconds: duration of a soak, if not the default."""
        self.bin, self.folder, self.messages, self.short = pathlib.Path(programs).resolve(), pathlib.Path(folder), messages, short
        self.seconds = seconds
        self.ending, self.probes, self.plot = contextlib.ExitStack(), 0, None
        self.store = pathlib.Path(store).resolve() if store else self.sample(20_000 if short else 500_000)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.ending.close()

    def sample(self, triangles, name="asteroid"):
        model, store = self.folder / f"{name}.ply", self.folder / f"{name}.lode"
        for command in (["sample", "asteroid", "--triangles", triangles, "-o", model], ["build", model, "-o", store, "--quiet"]):
            subprocess.run([self.bin / "lodestreamd", *map(str, command)], check=True, stdout=subprocess.DEVNULL)
        return store

    def server(self, *options, **where):
        server = Server(self, *options, **where)
        self.ending.callback(server.end)
        return server

    def run(self, command, **options):
        """Starts a process, which is killed at the end if it still runs."""
        process = start(command, **options)
        self.ending.callback(self.stop, process)
        return process

    @staticmethod
    def stop(process):
        process.kill()
        process.wait()
        if process.stdout:
            process.stdout.close()

    def haproxy(self, servers):
        """Starts HAProxy, which distributes connections to the servers that are ready. Returns its address."""
        port = free_port()
        lines = "\n".join(f"  server s{number} {server.listen} check addr {server.host} port {server.metrics.rsplit(':', 1)[1]}"
                          for number, server in enumerate(servers))
        config = self.folder / f"haproxy-{port}.cfg"
        config.write_text(f"""
defaults
  mode tcp
  timeout connect 2s
  timeout client 120s
  timeout server 120s
  default-server inter 200ms fall 1 rise 1
backend lodestream
  balance leastconn
  option httpchk GET /readyz
  option redispatch
  retries 3
{lines}
frontend clients
  bind 127.0.0.1:{port}
  default_backend lodestream
""")
        self.run(["haproxy", "-db", "-q", "-f", config])
        wait_for(port)
        return f"127.0.0.1:{port}"

    def crowd(self, listen, clients, seconds, prefix=(), store=None, authority=None, full=False):
        """Starts `lodestream loadtest`, whose clients arrive within a quarter of the time. With an authority, the clients use
        TLS. full: clients that move, refine and decode as a window does."""
        target = f"lode{'s' if authority else ''}://{listen}/{(store or self.store).stem}"
        kind = ["--full", "--path", "walk", "--cache", "off"] if full else ["--decode-off"]
        return self.run([*prefix, self.bin / "lodestream", "loadtest", target, "--clients", clients, "--seconds", seconds, *kind,
                         "--json", *(["--ca-file", authority] if authority else [])], stdout=subprocess.PIPE, text=True)

    def probe(self, listen, seconds, requests=None, every=0.05, prefix=(), store=None, model=None, authority=None):
        """Starts probe.py for the blobs of a store. With `requests`, the probe is greedy and always has this number of open
        requests."""
        store = store or self.store
        blobs = json.loads(subprocess.run([self.bin / "lodestreamd", "info", store, "--json"], check=True, capture_output=True,
                                          text=True).stdout)["payloads"]
        self.probes += 1
        command = [*prefix, "/usr/bin/python3", LOAD / "probe.py", listen, model or store.stem, blobs, seconds, "--seed", self.probes, "--every", every]
        command += ["--open", requests] if requests else []
        command += ["--ca-file", authority] if authority else []
        return self.run(command, env=dict(os.environ, PYTHONPATH=str(self.messages)), stdout=subprocess.PIPE, text=True)


def result(process):
    """Waits for a client of the stage, and returns the JSON object that it has printed."""
    told = process.communicate(timeout=600)[0]
    if not told or process.returncode not in (0, 1):  # status 1: the result contains errors
        sys.exit(f"a client ended with {process.returncode} and {'a' if told else 'without a'} result")
    return json.loads(told)


def probe_row(times, since=0, until=math.inf):
    """Returns the median, 99th percentile and longest latency of the requests of a part of the time, as texts."""
    late = [ms for t, ms in times if since <= t < until]
    if not late:
        return "none", "none", "none"
    return tuple(f"{ms:.1f} ms" for ms in (statistics.median(late), percentile(late, 0.99), max(late)))


def print_table(heads, rows):
    for row in (heads, ["---"] * len(heads), *rows):
        print("| " + " | ".join(map(str, row)) + " |", flush=True)


class Plot:
    """A plot of panels above each other, over the seconds of a run. Logarithmic panels have the same scale. Without matplotlib,
    there is no plot."""

    def __init__(self, title):
        self.title, self.panels = title, []

    def panel(self, what, *lines, log=False):
        """Adds a panel. lines: tuples of name, seconds and values."""
        self.panels.append((what, lines, log))

    def decades(self):
        """Returns the powers of ten around all logarithmic values."""
        values = [value for _, lines, log in self.panels if log for _, _, values in lines for value in values if value > 0] or [1]
        return 10.0 ** math.floor(math.log10(min(values))), 10.0 ** (math.floor(math.log10(max(values))) + 1)

    def write(self, path):
        try:
            import matplotlib
        except ImportError:
            return print(f"no plot in {path}: it takes Debian's python3-matplotlib", file=sys.stderr)
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(len(self.panels), 1, sharex=True, squeeze=False, figsize=(9, 2.4 * len(self.panels)))
        for axis, (what, lines, log) in zip(axes[:, 0], self.panels):
            for name, seconds, values in lines:
                axis.plot(seconds, values, "." if log else "-", markersize=3, linewidth=1, label=name)
            axis.set_ylabel(what)
            axis.grid(alpha=0.3)
            if log:
                axis.set_yscale("log")
                axis.set_ylim(*self.decades())
                axis.yaxis.set_major_formatter("{x:g}")
                axis.yaxis.set_minor_formatter("")
            if len(lines) > 1:
                axis.legend(fontsize="small")
        axes[-1, 0].set_xlabel("seconds")
        figure.suptitle(self.title)
        figure.tight_layout()
        figure.savefig(path, dpi=80)
        pyplot.close(figure)
