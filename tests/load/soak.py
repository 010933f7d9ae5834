"""A server under load for long while everything around it changes: nothing grows, and nothing fails that was not made to."""
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
PARTS, STANDARD_ERRORS = 15, 4  # of a run after its first quarter, in which caches and pools fill
LEAST_BYTES, LEAST_DESCRIPTORS = 1 << 20, 2  # what is not told from steps of malloc's and of the sampling


def growth(values):
    """How much more is held at the end of a run than after its first quarter, when those who come and go have gone, and by how much
    that may be wrong: of a straight line through the least values of the run's parts, and its standard error."""
    rest = values[len(values) // 4:]
    floors = [min(rest[part * len(rest) // PARTS:(part + 1) * len(rest) // PARTS]) for part in range(PARTS)]
    slope, start = statistics.linear_regression(range(PARTS), floors)
    beside = math.sqrt(sum((floor - start - slope * part) ** 2 for part, floor in enumerate(floors)) / (PARTS - 2))
    return slope * (PARTS - 1), (PARTS - 1) * beside / math.sqrt((PARTS ** 3 - PARTS) / 12)


def grows(values, least):
    """Whether that is more than chance, and than some least amount."""
    grown, error = growth(values)
    return grown > max(least, STANDARD_ERRORS * error)


class Watch:
    """What the server's process holds, every quarter of a second while the `with` lasts."""

    def __init__(self, process):
        self.process, self.seconds, self.resident, self.descriptors = process, [], [], []
        self.began, self.over, self.thread = time.monotonic(), threading.Event(), threading.Thread(target=self.run)

    def run(self):
        while not self.over.wait(SAMPLE_EVERY_S):
            self.seconds.append(time.monotonic() - self.began)
            self.resident.append(resident_bytes(self.process))
            self.descriptors.append(len(os.listdir(f"/proc/{self.process.pid}/fd")))

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()


class Surroundings:
    """What an operator, a disk and clients do to a server, by chance from a seed."""

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
        self.crowds, self.done = [], {}
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
        """Two crowds at a time. Returns what those told that have ended by themselves."""
        ended = [crowd for crowd in self.crowds if crowd.poll() is not None]
        self.crowds = [crowd for crowd in self.crowds if crowd.poll() is None]
        while len(self.crowds) < 2 and until - time.monotonic() > CROWD_S[0]:
            seconds = min(self.random.uniform(*CROWD_S), until - time.monotonic())
            self.crowds.append(self.stage.crowd(self.listen, self.random.randint(5, self.most_clients), seconds,
                                                authority=self.authority.certificate, store=self.path("steady")))
        return [result(crowd) for crowd in ended]


def soak(stage):
    """Half an hour of crowds, reloads, new certificates and stores, killed clients and a damaged store; 2 minutes if short."""
    seconds = 110 if stage.short else 1800
    around = Surroundings(stage)
    told, until = [], time.monotonic() + seconds
    with Watch(around.server.process) as watch:
        probes = {model: stage.probe(around.listen, seconds, store=around.other, model=model, authority=around.authority.certificate)
                  for model in MODELS}
        while time.monotonic() < until:
            told += around.keep_crowds(until)
            around.act()
            time.sleep(min(ACT_EVERY_S, max(0, until - time.monotonic())))
        told += [result(crowd) for crowd in around.crowds]
        probed = {model: result(probe) for model, probe in probes.items()}
    figures = around.server.figures()
    late = [ms for model in ("steady", "changing") for _, ms in probed[model]["times"]]
    kinds = ("lost", "errors", "failed_wishes", "first_error")
    broken = [{kind: run[kind] for kind in kinds} for run in told if any(run[kind] for kind in kinds)]
    clients, lost = sum(run["clients"] for run in told), sum(run["lost"] + run["errors"] + run["failed_wishes"] for run in told)
    grown, descriptors = (f"{amount:+.1f} ± {error:.1f}" for amount, error in
                          (growth([r / 1e6 for r in watch.resident]), growth(watch.descriptors)))
    print_table(("done to it", "times"), sorted(around.done.items()))
    print()
    print_table(("seconds", "clients that ended by themselves", "lost, failed, given up", "single wishes", "p99", "failed", "damaged told",
                 "resident, mean", "grown", "descriptors, mean", "grown"),
                [(seconds, clients, lost, len(late), f"{percentile(late, 0.99):.1f} ms", probed["steady"]["failed"] + probed["changing"]["failed"],
                  f"{figures['model_damaged_blobs_total']:.0f}", f"{statistics.mean(watch.resident) / 1e6:.1f} MB", f"{grown} MB",
                  f"{statistics.mean(watch.descriptors):.0f}", descriptors)])
    plot = Plot("soak")
    plot.panel("resident MB", ("", watch.seconds, [r / 1e6 for r in watch.resident]))
    plot.panel("descriptors", ("", watch.seconds, watch.descriptors))
    plot.panel("a wish's ms", ("", *zip(*probed["steady"]["times"])), log=True)
    assert lost == probed["steady"]["failed"] == probed["changing"]["failed"] == 0, f"something failed that was not made to: {broken}"
    assert set(around.done) == set(ACTIONS) and figures["model_damaged_blobs_total"] > 0, "not all was done to it"
    assert not grows(watch.resident, LEAST_BYTES), "memory grows"
    assert not grows(watch.descriptors, LEAST_DESCRIPTORS), "descriptors grow"
    return plot
