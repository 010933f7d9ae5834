"""Scenarios with many clients of one server. They measure the latency of requests."""
import statistics

from stage import Plot, Sampler, print_table, probe_row, rates, result

CROWD_HEADS = ("clients", "requests a second", "MB/s", "visible, median", "p99", "first image, median", "p99", "lost", "errors")


def crowd_row(run):
    visible, image = run["latency_ms"]["visible"], run["first_image_ms"]
    return (run["clients"], f"{run['blobs'] / run['seconds']:.0f}", f"{run['bytes'] / run['seconds'] / 1e6:.1f}", f"{visible['p50']:.1f} ms",
            f"{visible['p99']:.1f} ms", f"{image['p50']:.1f} ms", f"{image['p99']:.1f} ms", run["lost"], run["errors"])


def crowd_plot(title, sampler, *probes):
    """Describes a crowd. probes: pairs of a name and the JSON object that probe.py printed."""
    plot, samples = Plot(title), sampler.samples
    plot.panel("a request's ms", *((name, *zip(*probe["times"])) for name, probe in probes if probe["times"]), log=True)
    plot.panel("connections", ("", [s["t"] for s in samples], [s.get("connections", 0) for s in samples]))
    seconds, bytes_a_second = rates(samples, "model_sent_bytes_total")
    plot.panel("MB/s", ("", seconds, [rate / 1e6 for rate in bytes_a_second]))
    return plot


def arrive(stage, clients, seconds, title):
    """Runs clients that arrive within the first quarter of the scenario. The server must serve all of them."""
    server = stage.server("--max-connections", clients + 100)
    with Sampler([server]) as sampler:
        probe, crowd = stage.probe(server.listen, seconds), stage.crowd(server.listen, clients, seconds)
        run, probed = result(crowd), result(probe)
    print_table(CROWD_HEADS, [crowd_row(run)])
    print()
    print_table(("one request at a time beside them, median", "p99", "longest", "failed", "server's memory", "its CPU"),
                [(*probe_row(probed["times"]), probed["failed"], f"{sampler.most('memory_bytes') / 1e6:.1f} MB",
                  f"{100 * server.cpu_seconds() / seconds:.0f} %")])
    stage.plot = crowd_plot(title, sampler, ("beside them", probed))
    assert run["errors"] == run["lost"] == run["failed_requests"] == probed["failed"] == 0, "not everybody was served"


def steady(stage):
    """A steady crowd: 500 clients circle a model for 30 s."""
    arrive(stage, *((20, 4) if stage.short else (500, 30)), "steady crowd")


def flash(stage):
    """A flash crowd: a thousand clients arrive within 5 s."""
    arrive(stage, *((50, 4) if stage.short else (1000, 20)), "flash crowd")


def greedy(stage):
    """One greedy client, which always has 256 open requests, among polite clients."""
    clients, seconds = (10, 3) if stage.short else (50, 10)
    server = stage.server()
    rows, probes = [], []
    with Sampler([server]) as sampler:
        for name, requests in (("without it", None), ("beside it", 256)):
            began = sampler.samples[-1]["t"] if sampler.samples else 0
            hog = stage.probe(server.listen, seconds, requests) if requests else None
            probe, crowd = stage.probe(server.listen, seconds), stage.crowd(server.listen, clients, seconds)
            run, probed = result(crowd), result(probe)
            taken = result(hog) if hog else dict(bytes=0, seconds=1)
            visible = run["latency_ms"]["visible"]
            rows.append((name, *probe_row(probed["times"]), f"{visible['p50']:.1f} ms", f"{visible['p99']:.1f} ms", run["lost"],
                         f"{taken['bytes'] / taken['seconds'] / 1e6:.1f} MB/s"))
            probes.append((name, dict(times=[(t + began, ms) for t, ms in probed["times"]])))
            assert run["errors"] == run["lost"] == probed["failed"] == 0, "the polite were not served"
            assert not hog or taken["bytes"] > 0, "the greedy one got nothing"
    stage.plot = crowd_plot("one greedy client among polite ones", sampler, *probes)
    print_table(("one request at a time", "median", "p99", "longest", f"visible requests of {clients} clients, median", "p99", "lost",
                 "the greedy one"), rows)
    alone, beside = (statistics.median(ms for _, ms in probe["times"]) for _, probe in probes)
    assert beside <= 4 * alone + 20, f"the polite wait {beside:.1f} ms instead of {alone:.1f} ms"
