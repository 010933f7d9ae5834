#!/usr/bin/env python3
"""Tests that run.sh refuses a file that is no model before it installs packages or builds anything."""

import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parent.parent / "run.sh"
NEITHER = ", neither a PLY file nor a store; "
ZEROES = bytes(80)


class Run(unittest.TestCase):
    """Runs a copy of the script. Beside it, the installer is a stub that records its call and fails."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        shutil.copy(SCRIPT, self.folder)
        self.calls = self.folder / "calls"
        (self.folder / "docker").mkdir()
        installer = self.folder / "docker" / "install-packages.sh"
        installer.write_text(f"#!/usr/bin/env bash\necho called >> '{self.calls}'\nexit 1\n")
        installer.chmod(0o755)

    def run_script(self, *words):
        return subprocess.run(["bash", "run.sh", *words], cwd=self.folder, capture_output=True, text=True, check=False)

    def assert_refused(self, name, words):
        result = self.run_script(name)
        self.assertEqual(result.returncode, 1, name)
        self.assertEqual(result.stderr, f"run.sh: {words}\n")
        self.assertFalse(self.calls.exists(), name)
        self.assertFalse((self.folder / "build").exists(), name)

    def test_names_a_mesh_of_another_format(self):
        for name, content, kind in (
            ("a.obj", b"v 0 0 0\n", "an OBJ"),
            ("A.OFF", b"OFF\n8 6 0\n", "an OFF"),
            ("a.stl", ZEROES, "an STL"),
            ("a.glb", b"glTF\2\0\0\0", "a GLB (binary glTF)"),
            ("a.gltf", b"{}", "a glTF"),
            ("a.fbx", b"Kaydara FBX Binary  \0", "an FBX"),
            ("a.3mf", b"PK\3\4\x14\0", "a 3MF"),
        ):
            (self.folder / name).write_bytes(content)
            ply = name[:-len(Path(name).suffix)] + ".ply"
            self.assert_refused(name, f"{name} is {kind}{NEITHER}Lodestream reads PLY: convert it (MeshLab, Blender, "
                                f"`assimp export {name} {ply}`)")

    def test_names_files_of_other_kinds(self):
        for name, content, words in (
            ("a.ply", b"", "is empty; copy or export it again"),
            ("b.ply", b"\x89PNG\r\n\x1a\n", f"is a picture{NEITHER}name the PLY file of the mesh"),
            ("c.ply", b"RIFF\1\2\3\4WEBPVP8 ", f"is a picture{NEITHER}name the PLY file of the mesh"),
            ("a.zip", b"PK\3\4\x14\0", "is a zip archive; unpack it first"),
            ("a.ply.xz", b"\xfd7zXZ\0", "is compressed or an archive; unpack it first"),
            ("notes", b"hello\n", "is neither a PLY file nor a store; Lodestream reads PLY"),
        ):
            (self.folder / name).write_bytes(content)
            self.assert_refused(name, f"{name} {words}")

    def test_names_what_is_no_file(self):
        self.assert_refused("docker", "docker is a directory; name a store or a PLY in it")
        self.assert_refused("/dev/null", "/dev/null is a pipe or a device; name a store or a PLY, a file")
        self.assert_refused("gone.ply", "no such file: gone.ply; name a PLY mesh, or nothing for a sample model")

    def test_passes_on_what_the_programs_may_show(self):
        for name, content in (("a.obj", b"ply\nformat"), ("a.stl", b"LODE\r\n\x1a\n"), ("a.json", b"{}"),
                              ("-", b""), ("lodes://host/model", b"")):
            with self.subTest(name):
                self.calls.unlink(missing_ok=True)
                if content:
                    (self.folder / name).write_bytes(content)
                self.run_script(name)
                self.assertTrue(self.calls.exists())


if __name__ == "__main__":
    unittest.main()
