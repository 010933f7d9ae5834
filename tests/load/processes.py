"""Processes for benchmarks and scenarios. A process ends with the process that started it, however the latter ends."""
import contextlib
import ctypes
import os
import pathlib
import signal
import socket
import subprocess
import sys
import time


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1


def start(command, **options):
    """Starts a process. The system kills it when this process ends, however it ends. Ctrl-C in a terminal does not reach the
    started process."""
    return subprocess.Popen([str(part) for part in command], preexec_fn=lambda: LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL),
                            start_new_session=True, **options)


@contextlib.contextmanager
def running(command, **options):
    process = start(command, **options)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


def wait_for(port):
    for _ in range(100):
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
            return
        time.sleep(0.05)
    sys.exit(f"nothing listens on port {port}")


def eventually(what, seconds=120):
    """Calls what() until its result is true, and returns the result."""
    end = time.monotonic() + seconds
    while not (found := what()):
        assert time.monotonic() < end, "it did not come to that"
        time.sleep(0.01)
    return found


def cpu_seconds(process):
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident_bytes(process, kind="VmRSS"):
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    return 1024 * int(next(line for line in status.splitlines() if line.startswith(f"{kind}:")).split()[1])


class Authority:
    """A certificate authority. Its folder contains certificate.pem and the certificates that it issues."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder, "authority")
        self.folder.mkdir()
        self.certificate = self.folder / "certificate.pem"
        self.openssl("req", "-x509", "-subj", "/CN=an authority", "-keyout", self.folder / "authority.key", "-out", self.certificate)

    def openssl(self, *arguments):
        # State the usage of the key, because Python 3.13 accepts no other certificates.
        subprocess.run(["openssl", *map(str, arguments), "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
                        "-addext", "keyUsage=critical,digitalSignature,keyCertSign"], check=True, capture_output=True)

    def issue(self, host):
        """Issues cert.pem and key.pem, and renames each into place. Returns their folder."""
        new = [self.folder / "new.pem", self.folder / "new.key"]
        self.openssl("req", "-x509", "-CA", self.certificate, "-CAkey", self.folder / "authority.key", "-subj", f"/CN={host}", "-addext",
                     f"subjectAltName=DNS:{host}",
                     "-keyout", new[1], "-out", new[0])
        for made, name in zip(new, ("cert.pem", "key.pem")):
            os.rename(made, self.folder / name)
        return self.folder


@contextlib.contextmanager
def display(frames=None):
    """Starts an invisible display. Yields its name. The folder `frames` gets the file Xvfb_screen0 with its pixels."""
    reader, writer = os.pipe()
    command = ["Xvfb", "-displayfd", writer, "-screen", "0", "1400x900x24", "-nolisten", "tcp", *(["-fbdir", frames] if frames else [])]
    with running(command, pass_fds=[writer], stderr=subprocess.DEVNULL):
        os.close(writer)
        with open(reader) as said:
            yield f":{said.readline().strip()}"


def self_signed(folder):
    """Writes cert.pem and key.pem for localhost."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
                    "-subj", "/CN=localhost", "-keyout", folder / "key.pem", "-out", folder / "cert.pem"],
                   check=True, capture_output=True)
    return folder
