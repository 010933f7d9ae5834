"""Scenarios with servers that end under load. They measure the effect on clients."""
import signal
import time

from crowds import crowd_plot
from stage import Sampler, percentile, print_table, result


def longest_gap(times, seconds):
    """Returns the longest time between two answered requests of a probe."""
    moments = [0, *(t + ms / 1000 for t, ms in times), seconds]
    return max(b - a for a, b in zip(moments, moments[1:]))


def under_load(stage, title, servers, listen, seconds, act, allowed_failures):
    """Runs a crowd and a probe for some seconds, and calls act() meanwhile."""
    clients = 20 if stage.short else 200
    with Sampler(servers) as sampler:
        probe, crowd = stage.probe(listen, seconds), stage.crowd(listen, clients, seconds)
        act()
        run, probed = result(crowd), result(probe)
    visible = run["latency_ms"]["visible"]
    print_table(("clients", "visible, median", "p99", "longest", "moved when told", "connections lost", "requests failed", "given up",
                 "one request at a time, p99", "longest without one"),
                [(clients, f"{visible['p50']:.1f} ms", f"{visible['p99']:.1f} ms", f"{visible['max']:.0f} ms", run["moved"], run["lost"],
                  run["failed_requests"], run["gave_up"], f"{percentile([ms for _, ms in probed['times']], 0.99):.1f} ms",
                  f"{longest_gap(probed['times'], seconds):.2f} s")])
    stage.plot = crowd_plot(title, sampler, ("one request at a time", probed))
    assert run["gave_up"] == 0, f"clients have given up: {run['first_error']}"
    assert allowed_failures or run["failed_requests"] == 0, "requests failed"
    return run


def restart(stage):
    """The only server ends and starts again two seconds later."""
    server, seconds = stage.server(), 8 if stage.short else 24

    def act():
        time.sleep(seconds * 0.4)
        server.end()
        time.sleep(0.5 if stage.short else 2)
        server.start()

    run = under_load(stage, "the server is restarted", [server], server.listen, seconds, act, allowed_failures=True)
    assert run["moved"] + run["lost"] > 0, "nobody noticed"


def rolling_upgrade(stage):
    """Two servers behind HAProxy are replaced one after the other, and no request fails."""
    servers = [stage.server("--drain-delay", "1", "--drain-deadline", "10") for _ in range(2)]
    listen, seconds = stage.haproxy(servers), 12 if stage.short else 40

    def act():
        for server in servers:
            time.sleep(seconds * 0.3)
            status = server.end()
            assert status == 0, f"a server ended with {status}"
            server.start()

    run = under_load(stage, "rolling upgrade behind HAProxy", servers, listen, seconds, act, allowed_failures=False)
    assert run["moved"] > 0, "nobody was told"


def one_killed(stage):
    """One of two servers behind HAProxy is killed. The other server serves all clients."""
    servers = [stage.server(), stage.server()]
    listen, seconds = stage.haproxy(servers), 8 if stage.short else 24

    def act():
        time.sleep(seconds * 0.5)
        servers[0].end(signal.SIGKILL)

    run = under_load(stage, "one of two servers is killed", servers, listen, seconds, act, allowed_failures=True)
    assert 0 < run["lost"] < run["clients"], "not some but all or none have noticed"
