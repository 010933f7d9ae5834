#!/usr/bin/env python3
"""Builds the browser's page again and compares the files: browser_rebuild_test.py

Needs root, and in LODESTREAM_WEB_ROOT a folder with a Debian 13 system that client/web/build.sh --root has made: it installs
packages there and downloads sources. Skipped without them.
"""
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCES = pathlib.Path(__file__).resolve().parents[2]
ROOT = os.environ.get("LODESTREAM_WEB_ROOT", "")


def built_files(sources):
    """Returns the checksums of the page's files and of the list of its sources."""
    web = sources / "client" / "web"
    return {str(path.relative_to(web)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in [*sorted((web / "dist").iterdir()), web / "dist.sha256"]}


def copy_tracked(to):
    """Copies the tracked files as they are, into a repository of their own."""
    git = ["git", "-c", "safe.directory=*"]
    names = subprocess.run([*git, "ls-files", "-z"], cwd=SOURCES, check=True, capture_output=True).stdout.split(b"\0")
    for name in filter(None, map(os.fsdecode, names)):
        if (SOURCES / name).is_file():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(SOURCES / name, to / name)
    for command in (["init", "--quiet"], ["add", "--force", "."]):
        subprocess.run([*git, *command], cwd=to, check=True)


class Rebuild(unittest.TestCase):
    def test_gives_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as name:
            copy = pathlib.Path(name)
            copy_tracked(copy)
            shutil.rmtree(copy / "client" / "web" / "dist")
            (copy / "client" / "web" / "dist.sha256").unlink()
            done = subprocess.run([copy / "client" / "web" / "build.sh", "--root", ROOT], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout[-2000:] + done.stderr[-2000:])
            self.assertEqual(built_files(copy), built_files(SOURCES))


if __name__ == "__main__":
    if os.geteuid() != 0 or not pathlib.Path(ROOT or "/nonexistent", "usr/bin/apt-get").exists():
        print("skipped: as root, set LODESTREAM_WEB_ROOT to the folder of client/web/build.sh --root")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
