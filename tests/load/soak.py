"""Scenario of a server under load for a long time while its stores, tokens, certificates and clients change.
Memory and descriptors must not grow, and only intended failures may happen."""
import contextlib
import math
import os
import pathlib
import random
import shutil
import signal
import statistics
import threading
import time

from processes import Authority, resident_bytes
from stage import SAMPLE_EVERY_S, Plot, percentile, print_table, result

ACTIONS = ("reload", "replace", "renew_certificate", "kill_a_crowd", "damage")
ACT_EVERY_S, CROWD_S, MODELS = 2, (5, 15), ("steady", "changing", "damaged")
MOST_FULL_CLIENTS = 4  # largest crowd of full clients; a core can serve about fifty, because they decode
LULL_EVERY_S, LULL_S = 60, 8  # in a lull, the server returns free memory within seconds
STANDARD_ERRORS = 3
# Growth below these values does not count. The server may keep up to 4 MiB of free memory.
LEAST_ALLOCATED, LEAST_RESIDENT, LEAST_DESCRIPTORS = 1 << 18, 5 << 20, 2


def growth(values):
    """Returns the growth from the first quarter of a run to its end, and the standard error of the growth. Both come from a
    straight line through the values in lulls. The first quarter does not count, because threads then get their arenas and pools
    fill."""
    rest = values[len(values) // 4:]
    count = len(rest)
    slope, start = statistics.linear_regression(range(count), rest)
    beside = math.sqrt(sum((value - start - slope * number) ** 2 for number, value in enumerate(rest)) / (count - 2))
    return slope * (count - 1), (count - 1) * beside / math.sqrt((count ** 3 - count) / 12)


def grows(values, least):
    """Returns true if the values grow more than by chance, and by more than `least`."""
    grown, error = growth(values)
    return grown > max(least, STANDARD_ERRORS * error)


class Watch:
    """Records the memory and descriptors of the server's process, four times a second during the `with`. Resident memory does
    not include the program's file, whose pages are loaded when their code first runs."""

    def __init__(self, server):
        self.server, self.seconds, self.allocated, self.resident, self.descriptors, self.lulls = server, [], [], [], [], []
        self.began, self.over, self.thread = time.monotonic(), threading.Event(), threading.Thread(target=self.run)

    def run(self):
        while not self.over.wait(SAMPLE_EVERY_S):
            process, figures = self.server.process, self.server.figures()
            self.seconds.append(time.monotonic() - self.began)
            self.allocated.append(figures["allocated_bytes"] if figures else math.inf)
            self.resident.append(resident_bytes(process, "RssAnon"))
            self.descriptors.append(len(os.listdir(f"/proc/{process.pid}/fd")))

    def lull(self, until):
        """Waits until a time. No client connects meanwhile."""
        since = time.monotonic() - self.began
        time.sleep(max(0, until - time.monotonic()))
        self.lulls.append((since, time.monotonic() - self.began))

    def in_lulls(self, values):
        """Returns the least value in each lull."""
        return [min(value for t, value in zip(self.seconds, values) if since <= t <= until) for since, until in self.lulls]

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()


class Surroundings:
    """Random actions of an operator, a disk and clients on a server, from a seed."""

    def __init__(self, stage):
        self.stage, self.random = stage, random.Random(1)
        self.folder, self.authority = stage.folder / "served", Authority(stage.folder)
        self.folder.mkdir()
        for model in MODELS:
            shutil.copy(stage.store, self.path(model))
        self.other = stage.sample(10_000, "other")
        self.certificate = self.authority.issue("localhost")
        self.server = stage.server("--tls-cert", self.certificate / "cert.pem", "--tls-key", self.certificate / "key.pem", store=self.folder)
        self.listen = self.server.listen.replace("127.0.0.1", "localhost")
        self.crowds, self.crowds_begun, self.done = [], 0, {}
        self.most_clients = 20 if stage.short else 150

    def path(self, model):
        return self.folder / f"{model}.lode"

    def act(self):
        action = self.random.choice([getattr(self, name) for name in ACTIONS])
        self.done[action.__name__] = self.done.get(action.__name__, 0) + 1
        action()

    def reload(self):
        self.server.process.send_signal(signal.SIGHUP)

    def replace(self):
        new = self.path("changing").with_suffix(".new")
        shutil.copy(self.random.choice((self.stage.store, self.other)), new)
        os.rename(new, self.path("changing"))
        self.reload()

    def renew_certificate(self):
        self.authority.issue("localhost")
        self.reload()

    def kill_a_crowd(self):
        if self.crowds:
            self.crowds.pop(self.random.randrange(len(self.crowds))).kill()

    def damage(self):
        with open(self.path("damaged"), "r+b") as store:
            store.seek(self.random.randrange(1000, os.path.getsize(store.name) - 1000))
            store.write(b"damaged")

    def keep_crowds(self, until):
        """Keeps two crowds running. Every third crowd has full clients. Returns the reports of the crowds that have ended by
        themselves."""
        ended = [crowd for crowd in self.crowds if crowd.poll() is not None]
        self.crowds = [crowd for crowd in self.crowds if crowd.poll() is None]
        while len(self.crowds) < 2 and until - time.monotonic() > CROWD_S[0]:
            seconds = min(self.random.uniform(*CROWD_S), until - time.monotonic())
            self.crowds_begun += 1
            full = self.crowds_begun % 3 == 0
            clients = self.random.randint(1, MOST_FULL_CLIENTS) if full else self.random.randint(5, self.most_clients)
            self.crowds.append(self.stage.crowd(self.listen, clients, seconds, authority=self.authority.certificate,
                                                store=self.path("steady"), full=full))
        return [result(crowd) for crowd in ended]


def play(around, watch, until, lull_every, act_every):
    """Runs crowds and actions, with lulls between. Returns the reports of the crowds."""
    told = []
    while (lull := time.monotonic() + lull_every) <= until + 1:  # the time since the start must not cost a lull
        while time.monotonic() < lull - LULL_S:
            told += around.keep_crowds(lull - LULL_S)
            around.act()
            time.sleep(min(act_every, max(0, lull - LULL_S - time.monotonic())))
        told += [result(crowd) for crowd in around.crowds]
        around.crowds.clear()
        watch.lull(lull)
    return told


def soak(stage):
    """Half an hour of crowds, reloads, new certificates and stores, killed clients and a damaged store; 2 minutes if short."""
    seconds = stage.seconds or (110 if stage.short else 1800)
    around = Surroundings(stage)
    with Watch(around.server) as watch:
        probes = {model: stage.probe(around.listen, seconds, store=around.other, model=model, authority=around.authority.certificate)
                  for model in MODELS}
        told = play(around, watch, time.monotonic() + seconds, *((18, 1) if stage.short else (LULL_EVERY_S, ACT_EVERY_S)))
        probed = {model: result(probe) for model, probe in probes.items()}
    figures = around.server.figures()
    late = [ms for model in ("steady", "changing") for _, ms in probed[model]["times"]]
    kinds = ("lost", "errors", "failed_requests", "first_error")
    broken = [{kind: run[kind] for kind in kinds} for run in told if any(run[kind] for kind in kinds)]
    clients, full = (sum(run["clients"] for run in told if run["full"] in kind) for kind in ((True, False), (True,)))
    lost = sum(run["lost"] + run["errors"] + run["failed_requests"] for run in told)
    allocated, resident, descriptors = (watch.in_lulls(values) for values in (watch.allocated, watch.resident, watch.descriptors))
    grown = [f"{amount:+.2f} ± {error:.2f}" for amount, error in (
        growth([bytes / 1e6 for bytes in allocated]), growth([bytes / 1e6 for bytes in resident]), growth(descriptors))]
    print_table(("done to it", "times"), sorted(around.done.items()))
    print()
    print_table(("seconds", "clients that ended by themselves", "of them full", "lost, failed, given up", "single requests", "p99", "failed",
                 "damaged told"),
                [(seconds, clients, full, lost, len(late), f"{percentile(late, 0.99):.1f} ms",
                  probed["steady"]["failed"] + probed["changing"]["failed"], f"{figures['model_damaged_blobs_total']:.0f}")])
    print()
    print_table(("the server's", "mean", "in lulls, mean", "least", "most", "grown"),
                [(name, *(f"{value / unit:.{digits}f}" for value in (statistics.mean(filter(math.isfinite, values)), statistics.mean(lulls),
                                                                     min(lulls), max(lulls))), more)
                 for name, values, lulls, unit, digits, more in (
                     ("allocated memory, MB", watch.allocated, allocated, 1e6, 2, grown[0]),
                     ("resident memory, MB", watch.resident, resident, 1e6, 2, grown[1]),
                     ("descriptors", watch.descriptors, descriptors, 1, 0, grown[2]))])
    stage.plot, lulls = Plot("soak"), [until for _, until in watch.lulls]
    stage.plot.panel("memory, MB", *((name, seconds, [bytes / 1e6 for bytes in values]) for name, seconds, values in (
        ("resident", watch.seconds, watch.resident), ("in lulls", lulls, resident), ("allocated in lulls", lulls, allocated))))
    stage.plot.panel("descriptors", ("", watch.seconds, watch.descriptors))
    stage.plot.panel("a request's ms", ("", *zip(*probed["steady"]["times"])), log=True)
    assert lost == probed["steady"]["failed"] == probed["changing"]["failed"] == 0, f"something failed that was not made to: {broken}"
    assert set(around.done) == set(ACTIONS) and figures["model_damaged_blobs_total"] > 0, "not all was done to it"
    assert full > 0 or stage.short, "no full client has come to an end"
    for what, values, least in (("memory", allocated, LEAST_ALLOCATED), ("resident memory", resident, LEAST_RESIDENT),
                                ("number of descriptors", descriptors, LEAST_DESCRIPTORS)):
        assert not grows(values, least), f"its {what} grows: {values}"
