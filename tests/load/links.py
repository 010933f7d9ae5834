"""Scenarios with slow links and slow disks. All need root, for network namespaces or control groups."""
import shutil
import subprocess

from stage import Plot, print_table, probe_row, result
from surroundings import forget, long_link, slow_disk

SERVER_SIDE = "10.9.0.1"


def over_link(stage, clients, seconds, beside=False, full=False, **link):
    """Runs a crowd on the far side of a link, and a probe there or (beside) on the server's side. full: full clients instead of
    trace clients."""
    with long_link(stage.bin, **link) as (near, far), stage.server(prefix=near, host=SERVER_SIDE) as server:
        probe = stage.probe(server.listen, seconds, every=0.05 if beside else 0.5, prefix=near if beside else far)
        crowd = stage.crowd(server.listen, clients, seconds, prefix=far, full=full) if clients else None
        return result(crowd) if crowd else None, result(probe)


def slow(stage):
    """Clients share a link of 2 Mbit/s, and one client has a fast link."""
    clients, seconds = (3, 4) if stage.short else (20, 20)
    link = dict(delay_ms=40, mbit_s=2, queue_ms=400, beside=True)
    stage.plot, rows = Plot("clients on a slow link, and one beside them on a fast one"), []
    for name, count, full in (("alone", 0, False), ("beside them", clients, False), ("beside full ones", clients, True)):
        run, probed = over_link(stage, count, seconds, full=full, **link)
        goodput = f"{8 * run['bytes'] / run['seconds'] / 1e6:.2f} Mbit/s" if run else ""
        visible = f"{run['latency_ms']['visible']['p50']:.0f} ms" if run else ""
        rows.append((name, *probe_row(probed["times"]), goodput, visible, run["lost"] if run else "",
                     f"{run['first_image_ms']['p99']:.0f} ms" if run else ""))
        stage.plot.panel(f"{name}: a request's ms", ("", *zip(*probed["times"])), log=True)
        assert probed["failed"] == 0 and (not run or run["errors"] == run["lost"] == 0), "somebody was not served"
    print_table(("one request at a time on the fast link", "median", "p99", "longest", f"{clients} on the slow link get",
                 "their visible requests, median", "lost", "their first image, p99"), rows)


def lossy(stage):
    """A link of 10 Mbit/s and 50 ms loses 0, 1 and 3 % of its packets."""
    clients, seconds = (2, 4) if stage.short else (4, 20)
    stage.plot, rows = Plot("a link that loses packets"), []
    for loss in (0, 1, 3):
        run, probed = over_link(stage, clients, seconds, loss_percent=loss)
        visible, image = run["latency_ms"]["visible"], run["first_image_ms"]
        rows.append((f"{loss} %", *probe_row(probed["times"]), f"{visible['p50']:.0f} ms", f"{visible['p99']:.0f} ms",
                     f"{image['p99']:.0f} ms", f"{8 * run['bytes'] / run['seconds'] / 1e6:.2f} Mbit/s", run["lost"]))
        stage.plot.panel(f"{loss} %: a request's ms", ("", *zip(*probed["times"])), log=True)
        assert run["errors"] == run["lost"] == probed["failed"] == 0, "somebody was not served"
    print_table(("lost packets", "one request at a time, median", "p99", "longest", f"visible requests of {clients} clients, median", "p99",
                 "first image, p99", "they get", "connections lost"), rows)


def larger_than_memory(stage):
    """Clients read a store of 100 MB at random, from a disk of 20 MB/s, in a control group of 48 MB. A small store stays in
    memory."""
    seconds, readers, folder = (4 if stage.short else 15), 4, stage.folder / "served"
    hot, cold = folder / "hot.lode", folder / "cold.lode"
    for made in (folder, stage.folder / "files"):
        made.mkdir()
    subprocess.run([stage.bin / "serving_store", "65536", cold, stage.folder / "files"], check=True, stdout=subprocess.DEVNULL)
    shutil.copy(stage.store, hot)
    stage.plot, rows = Plot("a store larger than memory"), []
    with slow_disk(cold, 20 << 20, 48 << 20) as slowly:
        with stage.server(prefix=slowly, store=folder) as server:
            result(stage.probe(server.listen, 1, store=hot))  # loads the store into memory, which is charged to the server's
                                                              # group
            for name, count in (("alone", 0), ("beside them", readers)):
                forget(cold)
                others = [stage.probe(server.listen, seconds, 8, store=cold) for _ in range(count)]
                probed = result(stage.probe(server.listen, seconds, store=hot))
                taken = sum(result(other)["bytes"] for other in others) / seconds / 1e6
                rows.append((name, *probe_row(probed["times"]), f"{taken:.1f} MB/s"))
                stage.plot.panel(f"{name}: a request's ms", ("", *zip(*probed["times"])), log=True)
                assert probed["failed"] == 0 and (taken > 0) == (count > 0), "somebody was not served"
    print_table(("one request at a time for what is in memory", "median", "p99", "longest", f"{readers} readers of the large store, 8 requests each"),
                rows)
