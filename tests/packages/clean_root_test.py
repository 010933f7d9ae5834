#!/usr/bin/env python3
"""Tests Debian packages of a build in a clean Debian root: clean_root_test.py BUILD

Needs root, debootstrap and a package mirror, and exits with 77 without them. LODESTREAM_CLEAN_ROOT names a root that debootstrap
has made before; the test copies it instead of making one.
"""
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
PACKAGES = ("lodestream", "lodestreamd", "liblodestream-dev")
# Programs whose caches and links the packages affect.
BESIDE = ("systemd", "man-db", "shared-mime-info", "desktop-file-utils")
# Folders that apt, dpkg and systemd change by themselves.
CHANGED_BY_TOOLS = ("dev", "proc", "run", "sys", "tmp", "var/cache", "var/log", "var/lib/apt", "var/lib/dpkg", "var/lib/systemd")
# Needs no unmounting: the kernel removes a mount namespace after its last process.
IN_ROOT = 'mount -t proc proc "$0/proc"; mount --rbind /dev "$0/dev"; mount --rbind /sys "$0/sys"; exec chroot "$0" "$@"'


def release():
    """Code name of this Debian release; the packages need its libraries."""
    fields = dict(line.split("=", 1) for line in pathlib.Path("/etc/os-release").read_text().splitlines() if "=" in line)
    return fields.get("VERSION_CODENAME", "") if fields.get("ID") == "debian" else ""


def why_not():
    """Returns the reason why no clean root can be made here; empty if one can."""
    if os.geteuid() != 0:
        return "only root can make a Debian root"
    if not release():
        return "this is not Debian"
    missing = [tool for tool in ("debootstrap", "dpkg-shlibdeps", "file", "unshare") if not shutil.which(tool)]
    return f"not installed: {', '.join(missing)}; docker/install-packages.sh package" if missing else ""


class CleanRoot(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name) / "root"
        self.here("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", pathlib.Path(folder.name) / "packages")
        made = os.environ.get("LODESTREAM_CLEAN_ROOT")
        if made:
            self.here("cp", "-a", made, self.root)
        else:
            self.here("debootstrap", "--variant=minbase", release(), self.root)
        shutil.copytree("/etc/apt", self.root / "etc/apt", dirs_exist_ok=True)
        self.packages = []
        for package in (pathlib.Path(folder.name) / "packages").glob("*.deb"):
            shutil.copy(package, self.root / "root")
            self.packages.append(f"/root/{package.name}")
        self.in_root("apt-get", "update")

    def here(self, *words):
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL,
                              env=dict(os.environ, DEBIAN_FRONTEND="noninteractive", LC_ALL="C.UTF-8"))
        self.assertEqual(done.returncode, 0, f"{words}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
        return done.stdout

    def in_root(self, *words):
        """Runs a command in the root."""
        return self.here("unshare", "--mount", "--pid", "--fork", "sh", "-ec", IN_ROOT, self.root, *words)

    def install(self, *words):
        self.in_root("apt-get", "install", "-y", "--no-install-recommends", *words)

    def files(self):
        """Returns every path outside of CHANGED_BY_TOOLS, with the target of each link and a hash of each
        file in /etc."""
        found = {}
        for folder, folders, names in os.walk(self.root):
            inside = os.path.relpath(folder, self.root)
            folders[:] = [name for name in folders if os.path.normpath(f"{inside}/{name}") not in CHANGED_BY_TOOLS]
            for name in [*names, *folders]:
                path, value = pathlib.Path(folder, name), ""
                if path.is_symlink():
                    value = os.readlink(path)
                elif path.is_file() and inside.split("/")[0] == "etc":
                    value = hashlib.sha256(path.read_bytes()).hexdigest()
                found[os.path.normpath(f"{inside}/{name}")] = value
        return found

    def check_programs(self):
        self.in_root("lodestreamd", "sample", "asteroid", "--triangles", "20000", "-o", "/root/a.ply")
        self.in_root("lodestreamd", "build", "/root/a.ply", "-o", "/root/a.lode", "--quiet")
        self.in_root("lodestreamd", "verify", "/root/a.lode")
        self.assertIn('"converged":true', self.in_root("lodestream", "fetch", "/root/a.lode", "--json", "--cache", "off")
                      .replace(" ", ""))
        for name in ("a.ply", "a.lode"):
            (self.root / "root" / name).unlink()

    def check_surroundings(self):
        for name in ("lodestream", "lodestreamd"):
            self.in_root("man", "-w", name)
        self.in_root("systemd-analyze", "verify", "/usr/lib/systemd/system/lodestreamd.service")
        self.assertIn("model/vnd.lodestream:*.lode", (self.root / "usr/share/mime/globs2").read_text())
        if (self.root / "usr/share/applications/lodestream.desktop").exists():
            self.assertIn("model/vnd.lodestream=lodestream.desktop",
                          (self.root / "usr/share/applications/mimeinfo.cache").read_text())

    def test_packages_install_run_and_leave_no_trace(self):
        self.assertEqual(len(self.packages), len(PACKAGES))
        needed = [self.here("dpkg-deb", "-f", f"{self.root}{package}", "Depends").strip() for package in self.packages]
        self.in_root("apt-get", "satisfy", "-y", "--no-install-recommends", ", ".join(needed))
        self.install(*BESIDE)
        before = self.files()

        self.install(*self.packages)
        self.check_programs()
        self.check_surroundings()
        self.in_root("systemctl", "enable", "lodestreamd")
        link = self.root / "etc/systemd/system/multi-user.target.wants/lodestreamd.service"
        self.assertTrue(link.is_symlink())

        self.in_root("apt-get", "purge", "-y", *PACKAGES)
        after = self.files()
        self.assertEqual({path for path in before.keys() | after.keys() if before.get(path) != after.get(path)}, set())


if __name__ == "__main__":
    if why := why_not():
        print(f"skipped: {why}")
        sys.exit(SKIPPED)
    BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
