#!/usr/bin/python3
"""What one core of a server gives, beside nginx on the same bytes: bench_serving.py BIN_DIR [throughput latency urgent]

throughput  64 KB and 8 KB blobs, some 1,500 of each, at random: nginx (sendfile off) and lodestreamd in turns, medians
latency     `lodestream loadtest --decode-off` with more and more clients, 99th percentiles by class
urgent      a visible wish of 24 KB behind as much prefetching as the window takes, at 10 Mbit/s and 50 ms, directly and
            through HAProxy; needs root, for network namespaces

Starts nginx and HAProxy itself. Server and clients each have one core. Needs nginx-light, wrk and haproxy, the programs
serving_store, serving_load and wan in BIN_DIR, and python3-flatbuffers. Prints tables for docs/benchmarks.md.
"""
import argparse
import contextlib
import json
import os
import pathlib
import socket
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
SERVER_CORE, CLIENT_CORE = "0", "1"
CONNECTIONS, IN_FLIGHT = 16, 8


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def running(command, **options):
    process = subprocess.Popen([str(part) for part in command], **options)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


@contextlib.contextmanager
def lodestreamd(bench, store, listen="127.0.0.1:0", prefix=()):
    """Yields its process and where it listens."""
    command = [*prefix, "taskset", "-c", SERVER_CORE, bench.bin / "lodestreamd", "serve", store, "--listen", listen,
               "--threads", 1, "--public", "--insecure"]
    with running(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        yield process, json.loads(process.stdout.readline())["listen"]


@contextlib.contextmanager
def nginx(folder, files):
    port = free_port()
    config = folder / "nginx.conf"
    config.write_text(f"""
        daemon off; master_process off; worker_processes 1; pid {folder}/nginx.pid; error_log {folder}/error.log;
        events {{ worker_connections 4096; }}
        http {{ access_log off; sendfile off; tcp_nodelay on; keepalive_requests 1000000000; open_file_cache max=4096;
                default_type application/octet-stream;
                server {{ listen 127.0.0.1:{port}; root {files}; }} }}""")
    with running(["taskset", "-c", SERVER_CORE, "nginx", "-c", config, "-e", folder / "error.log"]) as process:
        wait_for(port)
        yield process, port


def wait_for(port):
    for _ in range(100):
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
            return
        time.sleep(0.05)
    sys.exit(f"nothing listens on port {port}")


def cpu_seconds(process):
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def on_client_core(command):
    done = subprocess.run(["taskset", "-c", CLIENT_CORE, *map(str, command)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{command[0]}: {done.stderr}")
    return done.stdout


def measured(process, command):
    """Bytes a second, and bytes a CPU second of the server."""
    before = cpu_seconds(process)
    result = json.loads(on_client_core(command).splitlines()[-1])
    return result["bytes"] / result["seconds"], result["bytes"] / max(cpu_seconds(process) - before, 1e-9)


def write_lua(path, first, last):
    path.write_text(f"""
        request = function() return wrk.format("GET", "/" .. math.random({first}, {last})) end
        done = function(summary)
          io.write(string.format('\\n{{"bytes": %d, "seconds": %f}}\\n', summary.bytes, summary.duration / 1e6))
        end""")


def throughput(bench):
    print("| blobs at random | nginx, sendfile off | lodestreamd | ratio | nginx a CPU second | lodestreamd | ratio |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for size in (65536, 8192):
        folder = bench.folder / str(size)
        files, store = folder / "files", folder / "noise.lode"
        files.mkdir(parents=True)
        numbers = json.loads(subprocess.run([bench.bin / "serving_store", str(size), store, files], check=True,
                                            capture_output=True, text=True).stdout)
        write_lua(folder / "random.lua", numbers["first"], numbers["last"])
        with nginx(folder, files) as (web, web_port), lodestreamd(bench, store) as (ours, listen):
            wrk = ["wrk", "-t1", f"-c{CONNECTIONS}", f"-d{bench.seconds}", "-s", folder / "random.lua",
                   f"http://127.0.0.1:{web_port}"]
            load = [bench.bin / "serving_load", listen.rsplit(":", 1)[1], "noise", numbers["first"], numbers["last"],
                    CONNECTIONS, IN_FLIGHT, bench.seconds]
            measured(web, wrk), measured(ours, load)  # warm
            runs = [(*measured(web, wrk), *measured(ours, load)) for _ in range(bench.runs)]
        web_wall, web_cpu, our_wall, our_cpu = (statistics.median(column) / 1e6 for column in zip(*runs))
        wall = statistics.median(run[2] / run[0] for run in runs)
        cpu = statistics.median(run[3] / run[1] for run in runs)
        print(f"| {size // 1024} KB | {web_wall:.0f} MB/s | {our_wall:.0f} MB/s | **{wall:.2f}** | "
              f"{web_cpu:.0f} MB | {our_cpu:.0f} MB | **{cpu:.2f}** |", flush=True)


def sample_store(bench):
    model, store = bench.folder / "asteroid.ply", bench.folder / "asteroid.lode"
    for command in (["sample", "asteroid", "--triangles", "2000000", "-o", model], ["build", model, "-o", store, "--quiet"]):
        subprocess.run([bench.bin / "lodestreamd", *command], check=True, stdout=subprocess.DEVNULL)
    return store


def latency(bench):
    store = bench.store or sample_store(bench)
    print("| clients | wishes a second | MB/s | visible, median | p99 | longest | margin, p99 | first image, p99 | "
          "unanswered | errors | server's CPU | clients' CPU |")
    print("|" + " --- |" * 12)
    for clients in bench.clients:
        with lodestreamd(bench, store) as (server, listen):
            before = cpu_seconds(server)
            run = json.loads(on_client_core(
                [bench.bin / "lodestream", "loadtest", f"lode://{listen}/{store.stem}", "--clients", clients, "--seconds",
                 bench.load_seconds, "--decode-off", "--json"]))
            used = (cpu_seconds(server) - before) / bench.load_seconds
        visible, margin, image = run["latency_ms"]["visible"], run["latency_ms"]["margin"], run["first_image_ms"]
        print(f"| {clients} | {run['blobs'] / run['seconds']:.0f} | {run['bytes'] / run['seconds'] / 1e6:.0f} | "
              f"{visible['p50']:.1f} ms | **{visible['p99']:.1f} ms** | {visible['max']:.0f} ms | {margin['p99']:.1f} ms | "
              f"{image['p99']:.1f} ms | {run['unanswered']} | {run['errors']} | {100 * used:.0f} % | "
              f"{100 * run['cpu_seconds'] / run['seconds']:.0f} % |", flush=True)


@contextlib.contextmanager
def long_link(bench):
    """Two network namespaces with 50 ms and 10 Mbit/s between them; the server's address is 10.9.0.1."""
    near, far = f"lode-near-{os.getpid()}", f"lode-far-{os.getpid()}"
    for name in (near, far):
        subprocess.run(["ip", "netns", "add", name], check=True)
    try:
        with running([bench.bin / "wan", near, far, 25, 10, 0, 200], stdout=subprocess.PIPE, text=True) as wan:
            wan.stdout.readline()
            for name, address in ((near, "10.9.0.1/24"), (far, "10.9.0.2/24")):
                for command in (["addr", "add", address, "dev", "em0"], ["link", "set", "em0", "up"], ["link", "set", "lo", "up"]):
                    subprocess.run(["ip", "-n", name, *command], check=True)
            yield ["ip", "netns", "exec", near], ["ip", "netns", "exec", far]
    finally:
        for name in (near, far):
            subprocess.run(["ip", "netns", "del", name])


def urgent(bench):
    folder = bench.folder / "urgent"
    (folder / "files").mkdir(parents=True)
    store = folder / "noise.lode"
    numbers = json.loads(subprocess.run([bench.bin / "serving_store", "24576", store, folder / "files"], check=True,
                                        capture_output=True, text=True).stdout)
    config = folder / "haproxy.cfg"
    config.write_text("""
        defaults
          mode tcp
          timeout connect 5s
          timeout client 60s
          timeout server 60s
        listen lodestream
          bind 10.9.0.1:7401
          server one 10.9.0.1:7400\n""")
    print("| 24 KB, 10 Mbit/s, 50 ms | median | longest | round trips | bulk beside it |")
    print("| --- | --- | --- | --- | --- |")
    with long_link(bench) as (near, far):
        with lodestreamd(bench, store, "10.9.0.1:7400", near), running([*near, "haproxy", "-f", config]):
            time.sleep(0.5)
            for way, port in (("directly", 7400), ("through HAProxy", 7401)):
                environment = dict(os.environ, PYTHONPATH=str(bench.bin.parent / "tests" / "load"))
                done = subprocess.run(
                    [*far, "/usr/bin/python3", HERE.parent / "load" / "urgent_wish.py", f"10.9.0.1:{port}", "noise",
                     str(numbers["first"]), str(numbers["last"]), str(bench.wishes)],
                    env=environment, capture_output=True, text=True)
                if done.returncode != 0:
                    sys.exit(done.stderr)
                run = json.loads(done.stdout)
                print(f"| {way} | **{run['median_ms']:.0f} ms** | {run['max_ms']:.0f} ms | {run['median_ms'] / 50:.1f} | "
                      f"{run['bulk_mbit_s']:.1f} Mbit/s |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path, metavar="BIN_DIR")
    parser.add_argument("parts", nargs="*", metavar="PART", help="throughput, latency, urgent; all by default")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--seconds", type=int, default=4, help="of a run of throughput")
    parser.add_argument("--store", type=pathlib.Path, help="of latency; by default a sample of 2 million triangles")
    parser.add_argument("--load-seconds", type=int, default=20)
    parser.add_argument("--clients", type=int, nargs="*", default=[1, 16, 256, 1000, 2000, 3000])
    parser.add_argument("--wishes", type=int, default=40, help="urgent ones")
    bench = parser.parse_args()
    bench.bin = bench.bin.resolve()
    parts = dict(throughput=throughput, latency=latency, urgent=urgent)
    with tempfile.TemporaryDirectory() as folder:
        bench.folder = pathlib.Path(folder)
        for name in bench.parts or parts:
            parts[name](bench)
            print()


if __name__ == "__main__":
    main()
