#!/usr/bin/python3
"""Measures throughput and latency of a server on one core, compared with nginx on the same bytes:
bench_serving.py BIN_DIR [PART ...]

throughput  64 KB and 8 KB blobs, some 1,500 of each, at random: nginx (sendfile off) and lodestreamd in turns, medians
tls         the same under TLS 1.3
http        the files of a tileset over HTTP, all at random and the smallest: nginx on exported files and `serve --http` in turns; the
            same beside 9,000 idle connections, with their memory; ratios of requests
fairness    share of a connection with 256 open requests beside eight with 64, and one request at a time beside it
clients     one request at a time from each of 1 to 1,000 clients: percentiles beside nginx
idle        memory of 10,000 connections that do nothing, and of 1,000 under TLS
cold        one request at a time for blobs in memory, alone and beside reads of a slow disk; needs root, for control groups
latency     `lodestream loadtest --decode-off` with growing numbers of clients: percentiles by class, and of the server's histograms
cores       clients of `lodestream loadtest` per core, of the client's and of the server's, by CPU seconds
urgent      a visible request of 24 KB behind a window full of prefetches at 10 Mbit/s and 50 ms, directly and through HAProxy, under
            each congestion control of the system; needs root, for network namespaces

Starts nginx and HAProxy itself. Server and clients each have one core. Needs `docker/install-packages.sh bench`, the programs
serving_store, serving_load and wan in BIN_DIR, and python3-flatbuffers. Prints rows for compare.py.
"""
import argparse
import contextlib
import itertools
import json
import os
import pathlib
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request

from rows import print_row

LOAD = pathlib.Path(__file__).resolve().parent.parent / "load"
sys.path.insert(0, str(LOAD))
from processes import cpu_seconds, free_port, resident_bytes, running, self_signed, start, wait_for  # noqa: E402
from surroundings import forget, long_link, plain_haproxy, slow_disk  # noqa: E402

SERVER_CORE, CLIENT_CORE = "0", "1"
CONNECTIONS, IN_FLIGHT = 16, 8


@contextlib.contextmanager
def lodestreamd(bench, store, listen="127.0.0.1:0", prefix=(), tls=None, metrics=None, http=None):
    """Yields the server's process and address, which is that of HTTP if `http` is given."""
    command = [*prefix, "taskset", "-c", SERVER_CORE, bench.bin / "lodestreamd", "serve", store, "--listen", listen,
               "--threads", 1, "--public", "--insecure"]
    command += ["--tls-cert", tls / "cert.pem", "--tls-key", tls / "key.pem"] if tls else []
    command += ["--metrics", metrics] if metrics else []
    command += ["--http", http] if http else []
    with running(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        yield process, json.loads(process.stdout.readline())["http" if http else "listen"]


@contextlib.contextmanager
def nginx(folder, files, tls=None, fields=""):
    port = free_port()
    secure = f"ssl_certificate {tls}/cert.pem; ssl_certificate_key {tls}/key.pem; ssl_protocols TLSv1.3;" if tls else ""
    config = folder / "nginx.conf"
    config.write_text(f"""
        daemon off; master_process off; worker_processes 1; pid {folder}/nginx.pid; error_log {folder}/error.log;
        events {{ worker_connections 16384; }}
        http {{ access_log off; sendfile off; tcp_nodelay on; keepalive_requests 1000000000; open_file_cache max=4096;
                default_type application/octet-stream;
                server {{ listen 127.0.0.1:{port}{" ssl" if tls else ""}; {secure} root {files}; {fields} }} }}""")
    with running(["taskset", "-c", SERVER_CORE, "nginx", "-c", config, "-e", folder / "error.log"]) as process:
        wait_for(port)
        yield process, port


def on_client_core(command):
    done = subprocess.run(["taskset", "-c", CLIENT_CORE, *map(str, command)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{command[0]}: {done.stderr}")
    return done.stdout


def measured(process, command, what="bytes"):
    """Returns bytes or requests per second, and per CPU second of the server."""
    before = cpu_seconds(process)
    result = json.loads(on_client_core(command).splitlines()[-1])
    return result[what] / result["seconds"], result[what] / max(cpu_seconds(process) - before, 1e-9)


def write_lua(path, first, last):
    path.write_text(f"""
        request = function() return wrk.format("GET", "/" .. math.random({first}, {last})) end
        done = function(summary, latency)
          io.write(string.format('\\n{{"bytes": %d, "requests": %d, "seconds": %f, "p50_ms": %f, "p99_ms": %f}}\\n', summary.bytes,
                                 summary.requests, summary.duration / 1e6, latency:percentile(50) / 1e3, latency:percentile(99) / 1e3))
        end""")


def make_store(bench, folder, size):
    """Makes noise.lode and files with blobs of a size; returns the numbers of the first and the last."""
    (folder / "files").mkdir(parents=True)
    done = subprocess.run([bench.bin / "serving_store", str(size), folder / "noise.lode", folder / "files"], check=True,
                          capture_output=True, text=True)
    return json.loads(done.stdout)


def tls(bench):
    throughput(bench, self_signed(bench.folder))


def throughput(bench, tls=None):
    for size in (65536, 8192):
        folder = bench.folder / f"{size}{'-tls' if tls else ''}"
        numbers = make_store(bench, folder, size)
        write_lua(folder / "random.lua", numbers["first"], numbers["last"])
        with (nginx(folder, folder / "files", tls) as (web, web_port),
              lodestreamd(bench, folder / "noise.lode", tls=tls) as (ours, listen)):
            wrk = ["wrk", "-t1", f"-c{CONNECTIONS}", f"-d{bench.seconds}", "-s", folder / "random.lua",
                   f"http{'s' if tls else ''}://127.0.0.1:{web_port}"]
            load = [bench.bin / "serving_load", listen.rsplit(":", 1)[1], "noise", numbers["first"], numbers["last"],
                    CONNECTIONS, IN_FLIGHT, bench.seconds, *(["tls"] if tls else [])]
            measured(web, wrk), measured(ours, load)  # warm
            runs = [(*measured(web, wrk), *measured(ours, load)) for _ in range(bench.runs)]
        web_wall, web_cpu, our_wall, our_cpu = (statistics.median(column) / 1e6 for column in zip(*runs))
        wall = statistics.median(run[2] / run[0] for run in runs)
        cpu = statistics.median(run[3] / run[1] for run in runs)
        print_row(part="throughput", blobs=f"{size // 1024} KB{', TLS' if tls else ''}", nginx_mb_s=web_wall, ours_mb_s=our_wall, ratio=wall,
                  nginx_mb_a_cpu_s=web_cpu, ours_mb_a_cpu_s=our_cpu, cpu_ratio=cpu)


def http(bench):
    folder = bench.folder / "http"
    (folder / "files").mkdir(parents=True)
    ply, store, files = folder / "asteroid.ply", folder / "asteroid.lode", folder / "files"
    for command in (["sample", "asteroid", "--triangles", "500000", "-o", ply], ["build", ply, "-o", store, "--quiet"],
                    ["export", store, "--tiles", files / "asteroid", "--quiet"]):
        subprocess.run([bench.bin / "lodestreamd", *command], check=True, stdout=subprocess.DEVNULL)
    tiles = sorted((path for path in files.rglob("*.glb")), key=lambda path: path.stat().st_size)
    scripts = {}
    for name, chosen in (("all", tiles), ("smallest", tiles[:1])):
        scripts[name] = folder / f"{name}.lua"
        urls = ", ".join(f'"/{tile.relative_to(files)}"' for tile in chosen)
        write_lua(scripts[name], 1, len(chosen))
        scripts[name].write_text(f"local urls = {{{urls}}}\n" + scripts[name].read_text().replace(
            '"/" .. math.random', "urls[math.random").replace(f"{len(chosen)})", f"{len(chosen)})]"))
    with (nginx(folder, files, fields=FIELDS) as (web, web_port),
          lodestreamd(bench, store, http="127.0.0.1:0") as (ours, listen), contextlib.ExitStack() as idle):
        for crowd in (0, 9000):
            before = resident_bytes(ours)
            for port in (web_port, listen.rsplit(":", 1)[1]) if crowd else ():
                opened = start(["/usr/bin/python3", "-c", IDLE_HTTP, port, crowd], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
                idle.callback(opened.kill)
                assert opened.stdout.readline() == "ready\n"
            grown = (resident_bytes(ours) - before) / max(crowd, 1)
            for name, script in scripts.items():
                loads = [["wrk", "-t1", f"-c{CONNECTIONS}", f"-d{bench.seconds}", "-s", script, f"http://127.0.0.1:{port}"]
                         for port in (web_port, listen.rsplit(":", 1)[1])]
                measured(web, loads[0]), measured(ours, loads[1])  # warm
                runs = [(*measured(web, loads[0], "requests"), *measured(ours, loads[1], "requests")) for _ in range(bench.runs)]
                web_wall, _, our_wall, _ = (statistics.median(column) for column in zip(*runs))
                print_row(part="http", files=f"{name}, {crowd} idle", nginx_requests_s=web_wall, our_requests_s=our_wall,
                          ratio=statistics.median(run[2] / run[0] for run in runs),
                          cpu_ratio=statistics.median(run[3] / run[1] for run in runs), **(dict(bytes_an_idle_connection=grown) if crowd else {}))


# Header fields that viewers from other hosts and caches need, as `serve --http` sends them.
FIELDS = """add_header Access-Control-Allow-Origin *; add_header Access-Control-Expose-Headers "Content-Length, Content-Range, ETag";
    add_header Timing-Allow-Origin *; add_header X-Content-Type-Options nosniff; add_header Referrer-Policy no-referrer;
    add_header Content-Security-Policy "default-src 'none'; connect-src 'self'; base-uri 'none'; form-action 'none'";
    add_header Cache-Control "public, max-age=31536000, immutable";"""
IDLE_HTTP = """
import resource, socket, sys
most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
clients = [socket.create_connection(("127.0.0.1", int(sys.argv[1]))) for _ in range(int(sys.argv[2]))]
for client in clients:
    client.sendall(b"HEAD /asteroid/tileset.json HTTP/1.1\\r\\nHost: localhost\\r\\n\\r\\n")
    client.recv(4096)
print("ready", flush=True)
sys.stdin.read()
"""


def clients(bench):
    folder = bench.folder / "clients"
    numbers = make_store(bench, folder, 24576)
    write_lua(folder / "random.lua", numbers["first"], numbers["last"])
    with (nginx(folder, folder / "files") as (_, web_port), lodestreamd(bench, folder / "noise.lode") as (_, listen)):
        for count in (1, 16, 256, 1000):
            wrk = ["wrk", "-t1", f"-c{count}", f"-d{bench.seconds}", "-s", folder / "random.lua", f"http://127.0.0.1:{web_port}"]
            load = [bench.bin / "serving_load", listen.rsplit(":", 1)[1], "noise", numbers["first"], numbers["last"], count, 1,
                    bench.seconds]
            runs = [[json.loads(on_client_core(command).splitlines()[-1]) for command in (wrk, load)] for _ in range(bench.runs)]
            web, ours = ([statistics.median(run[who][what] for run in runs) for what in ("p50_ms", "p99_ms")] for who in (0, 1))
            median, p99 = (statistics.median(ours[what] / web[what] for web, ours in runs) for what in ("p50_ms", "p99_ms"))
            print_row(part="clients", clients=f"{count} clients", nginx_p50_ms=web[0], nginx_p99_ms=web[1], ours_p50_ms=ours[0], ours_p99_ms=ours[1],
                      p50_ratio=median, p99_ratio=p99)


def idle(bench):
    folder = bench.folder / "idle"
    make_store(bench, folder, 8192)
    environment = dict(os.environ, PYTHONPATH=str(bench.bin.parent / "tests" / "load"))
    for count, tls in ((10000, None), (1000, self_signed(bench.folder))):
        with lodestreamd(bench, folder / "noise.lode", tls=tls) as (server, listen):
            before = resident_bytes(server)
            command = ["taskset", "-c", CLIENT_CORE, "/usr/bin/python3", LOAD / "idle_clients.py", listen, "noise",
                       count, *(["tls"] if tls else [])]
            with running(command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holders:
                if holders.stdout.readline() != "ready\n":
                    sys.exit("idle_clients.py failed")
                time.sleep(2)
                held = resident_bytes(server)
        print_row(part="idle", connections=f"{count}{', TLS' if tls else ''}", each_kb=(held - before) / count / 1024, server_mb=held / 1e6)


def load_beside(bench, listen, model, numbers, connections, in_flight, seconds):
    return start(
        ["taskset", "-c", CLIENT_CORE, bench.bin / "serving_load", listen.rsplit(":", 1)[1], model, numbers["first"],
         numbers["last"], connections, in_flight, seconds], stdout=subprocess.PIPE, text=True)


def fairness(bench):
    folder = bench.folder / "fairness"
    numbers = make_store(bench, folder, 24576)
    shares, indices, alone, beside = [], [], [], []
    with lodestreamd(bench, folder / "noise.lode") as (_, listen):
        request_times(bench, listen, "noise", numbers, 500)  # warm
        for _ in range(bench.runs):
            run = json.loads(load_beside(bench, listen, "noise", numbers, 9, "64,256", bench.seconds).communicate()[0])
            greedy, *others = run["each"]
            shares.append(greedy / statistics.mean(others))
            indices.append(sum(run["each"]) ** 2 / (9 * sum(n * n for n in run["each"])))
            alone.append(request_times(bench, listen, "noise", numbers, 500))
            greedy = load_beside(bench, listen, "noise", numbers, 1, 256, 60)
            beside.append(request_times(bench, listen, "noise", numbers, 500))
            greedy.terminate()
            greedy.communicate()
    print_row(part="fairness", what="256 open requests beside 64", share=statistics.median(shares), jain_index=statistics.median(indices))
    for name, runs in (("alone", alone), ("beside one with 256 open", beside)):
        median, p99 = (statistics.median(run[what] for run in runs) for what in ("median_ms", "p99_ms"))
        print_row(part="fairness", what=f"one request at a time, {name}", p50_ms=median, p99_ms=p99)


def python_client(bench, script, listen, model, numbers, amount):
    environment = dict(os.environ, PYTHONPATH=str(bench.bin.parent / "tests" / "load"))
    done = subprocess.run(["taskset", "-c", CLIENT_CORE, "/usr/bin/python3", LOAD / script, listen, model,
                           str(numbers["first"]), str(numbers["last"]), str(amount)], env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def request_times(bench, listen, model, numbers, count):
    return python_client(bench, "request_times.py", listen, model, numbers, count)


def cold(bench):
    folder = bench.folder / "served"
    folder.mkdir()
    numbers = {}
    for name in ("hot", "cold"):
        numbers[name] = make_store(bench, bench.folder / name, 65536)
        os.rename(bench.folder / name / "noise.lode", folder / f"{name}.lode")
    (folder / "hot.lode").read_bytes()  # in memory, and counted to this process
    runs = {False: [], True: []}
    with slow_disk(folder / "cold.lode", 20 << 20, 48 << 20) as slowly, lodestreamd(bench, folder, prefix=slowly) as (_, listen):
        request_times(bench, listen, "hot", numbers["hot"], 1000)  # warm
        for beside in (False, True) * bench.runs:
            forget(folder / "cold.lode")
            others = load_beside(bench, listen, "cold", numbers["cold"], 8, 8, 6) if beside else None
            run = request_times(bench, listen, "hot", numbers["hot"], 1000)
            taken = json.loads(others.communicate()[0]) if others else dict(bytes=0, seconds=1)
            runs[beside].append((run["median_ms"], run["p99_ms"], taken["bytes"] / taken["seconds"] / 1e6))
        forget(folder / "cold.lode")
        pongs = python_client(bench, "pong_times.py", listen, "cold", numbers["cold"], 4)
    for beside, measured_runs in runs.items():
        median, p99, rate = (statistics.median(column) for column in zip(*measured_runs))
        print_row(part="cold", what="a request beside cold reads" if beside else "a request alone", p50_ms=median, p99_ms=p99, cold_mb_s=rate)
    print_row(part="cold", what="a Ping beside its own connection's cold reads", p50_ms=pongs["median_ms"], p99_ms=pongs["p99_ms"], cold_mb_s=pongs["mbyte_s"])


def sample_store(bench):
    model, store = bench.folder / "asteroid.ply", bench.folder / "asteroid.lode"
    for command in (["sample", "asteroid", "--triangles", "2000000", "-o", model], ["build", model, "-o", store, "--quiet"]):
        subprocess.run([bench.bin / "lodestreamd", *command], check=True, stdout=subprocess.DEVNULL)
    return store


def visible_in_server(metrics, figure):
    """Returns the upper bounds of a histogram's buckets in milliseconds, with the number of visible requests
    up to each bound."""
    with urllib.request.urlopen(f"http://{metrics}/metrics", timeout=10) as answer:
        buckets = re.findall(rf'^lodestream_request_{figure}_seconds_bucket{{class="visible",le="(.*)"}} (\d+)$', answer.read().decode(), re.M)
    return [(1000 * float(end), int(count)) for end, count in buckets]


def at_most_ms(buckets, part):
    return next(end for end, count in buckets if count >= part * buckets[-1][1])


def latency(bench):
    store = bench.store or sample_store(bench)
    for clients in bench.clients:
        metrics = f"127.0.0.1:{free_port()}"
        with lodestreamd(bench, store, metrics=metrics) as (server, listen):
            before = cpu_seconds(server)
            run = json.loads(on_client_core(
                [bench.bin / "lodestream", "loadtest", f"lode://{listen}/{store.stem}", "--clients", clients, "--seconds",
                 bench.load_seconds, "--decode-off", "--json"]))
            used = (cpu_seconds(server) - before) / bench.load_seconds
            queue, send = (visible_in_server(metrics, figure) for figure in ("queue", "send"))
        visible, margin, image = run["latency_ms"]["visible"], run["latency_ms"]["margin"], run["first_image_ms"]
        print_row(part="latency", clients=f"{clients} clients", requests_a_s=run["blobs"] / run["seconds"], mb_s=run["bytes"] / run["seconds"] / 1e6,
                  visible_p50_ms=visible["p50"], visible_p99_ms=visible["p99"], visible_max_ms=visible["max"], margin_p99_ms=margin["p99"],
                  first_image_p99_ms=image["p99"], unanswered=run["unanswered"], errors=run["errors"], server_cpu=used,
                  clients_cpu=run["cpu_seconds"] / run["seconds"], first_chunk_p99_ms=at_most_ms(queue, 0.99),
                  last_chunk_p99_ms=at_most_ms(send, 0.99), last_chunk_p999_ms=at_most_ms(send, 0.999))


def cores(bench):
    store, seconds, ramp_s = bench.store or sample_store(bench), 15, 2
    for what, count, options, paths in (
            ("full: 10 views a second, 1280 × 720, 1 pixel, decoding", 16, ["--full"], ("orbit", "fly", "walk")),
            ("replaying requests, not decoding", 1000, ["--decode-off"], ("orbit", "walk")), ("replaying requests, decoding", 100, [], ("orbit", "walk"))):
        for path in paths:
            with lodestreamd(bench, store) as (server, listen):
                before = cpu_seconds(server)
                run = json.loads(on_client_core([bench.bin / "lodestream", "loadtest", f"lode://{listen}/{store.stem}", "--clients", count, "--seconds",
                                                 seconds, "--ramp", ramp_s, "--path", path, "--json", *options]))
                used = cpu_seconds(server) - before
            client_seconds = count * (seconds - ramp_s / 2)
            print_row(part="cores", clients=what, path=path, a_client_core=client_seconds / run["cpu_seconds"], a_server_core=client_seconds / used,
                      each_kb_s=run["bytes"] / client_seconds / 1e3)


def urgent(bench):
    folder = bench.folder / "urgent"
    numbers, store = make_store(bench, folder, 24576), folder / "noise.lode"
    controls = pathlib.Path("/proc/sys/net/ipv4/tcp_available_congestion_control").read_text().split()
    with long_link(bench.bin) as (near, far):
        with lodestreamd(bench, store, "10.9.0.1:7400", near), plain_haproxy(folder, "10.9.0.1:7401", "10.9.0.1:7400", near):
            time.sleep(0.5)
            for control, (way, port) in itertools.product(
                    [c for c in ("cubic", "bbr") if c in controls], (("directly", 7400), ("through HAProxy", 7401))):
                subprocess.run([*near, "ip", "route", "replace", "10.9.0.0/24", "dev", "em0", "congctl", control], check=True)
                environment = dict(os.environ, PYTHONPATH=str(bench.bin.parent / "tests" / "load"))
                done = subprocess.run(
                    [*far, "/usr/bin/python3", LOAD / "urgent_request.py", f"10.9.0.1:{port}", "noise",
                     str(numbers["first"]), str(numbers["last"]), str(bench.requests)],
                    env=environment, capture_output=True, text=True)
                if done.returncode != 0:
                    sys.exit(done.stderr)
                run = json.loads(done.stdout)
                print_row(part="urgent", way=f"{control}, {way}", p50_ms=run["median_ms"], max_ms=run["max_ms"], bulk_mbit_s=run["bulk_mbit_s"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path, metavar="BIN_DIR")
    parser.add_argument("parts", nargs="*", metavar="PART", help="one of the parts above; all by default")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--seconds", type=int, default=4, help="of a run of throughput")
    parser.add_argument("--store", type=pathlib.Path, help="of latency; by default a sample of 2 million triangles")
    parser.add_argument("--load-seconds", type=int, default=20)
    parser.add_argument("--clients", type=int, nargs="*", default=[1, 16, 256, 1000, 2000, 3000])
    parser.add_argument("--requests", type=int, default=40, help="urgent ones")
    bench = parser.parse_args()
    bench.bin = bench.bin.resolve()
    for ending in (signal.SIGTERM, signal.SIGHUP):  # exit as on SIGINT, so that servers, control groups and namespaces are removed
        signal.signal(ending, lambda number, _: sys.exit(128 + number))
    parts = dict(throughput=throughput, tls=tls, http=http, fairness=fairness, clients=clients, idle=idle, cold=cold, latency=latency,
                 cores=cores, urgent=urgent)
    with tempfile.TemporaryDirectory() as folder:
        bench.folder = pathlib.Path(folder)
        for name in bench.parts or parts:
            parts[name](bench)


if __name__ == "__main__":
    main()
