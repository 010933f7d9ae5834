#!/usr/bin/env python3
"""Runs the command lines of docs/embedding.md unchanged: they must install the library,
and build and run the examples.

    embedding_docs_test.py BUILD_DIR BIN_DIR SOURCE_DIR

The library is installed from BUILD_DIR, which is built already. make is hidden, since docker/packages.txt does not list it.
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

BUILD, BIN, SOURCE = (os.path.abspath(sys.argv.pop(1)) for _ in range(3))
HIDDEN = ("make", "gmake")


def blocks(text):
    """Fenced blocks of a document that consist of commands."""
    return [block for block in re.findall(r"^```\n(.*?)^```$", text, re.M | re.S) if re.match(r"[a-z./-]+ ", block)]


def path_without_make(folder):
    """Makes a folder of links to all programs except make."""
    for source in map(pathlib.Path, os.environ["PATH"].split(":")):
        for program in source.iterdir() if source.is_dir() else ():
            link = folder / program.name
            if program.name not in HIDDEN and not link.is_symlink():
                link.symlink_to(program)
    return str(folder)


class EmbeddingDocs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "programs").mkdir()
        self.path = path_without_make(self.folder / "programs")
        self.build_lines, self.example_lines = blocks(pathlib.Path(SOURCE, "docs", "embedding.md").read_text())

    def run_lines(self, lines, replaced, **environment):
        """Runs command lines like a user who pastes them into a shell. Returns what they print."""
        for old, new in replaced.items():
            self.assertIn(old, lines)
            lines = lines.replace(old, new)
        result = subprocess.run(["sh", "-ec", lines], cwd=self.folder, capture_output=True, text=True, check=False,
                                env={**os.environ, "PATH": self.path, **environment})
        self.assertEqual(result.returncode, 0, lines + result.stdout + result.stderr)
        return result.stdout

    def install(self):
        line, = re.findall(r"^cmake --install .*\n", self.build_lines, re.M)
        self.run_lines(line, {"build/headless": BUILD, "/usr/local": str(self.folder / "usr")})

    def serve(self):
        asteroid = self.folder / "asteroid.ply"
        for words in (("sample", "asteroid", "--triangles", "2000", "-o", asteroid),
                      ("build", asteroid, "-o", self.folder / "asteroid.lode")):
            subprocess.run([f"{BIN}/lodestreamd", *words], check=True, capture_output=True)
        server = subprocess.Popen([f"{BIN}/lodestreamd", "serve", self.folder / "asteroid.lode", "--listen", "127.0.0.1:0"],
                                  stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(lambda: (server.terminate(), server.wait(), server.stdout.close()))
        return json.loads(server.stdout.readline())["listen"]

    def test_builds_and_runs_the_examples_without_make(self):
        self.install()
        said = self.run_lines(self.example_lines, {"/usr/local": str(self.folder / "usr"), "localhost": self.serve()},
                              CMAKE_BUILD_PARALLEL_LEVEL="1")
        self.assertIn(" triangles in ", said)

    def test_names_a_preset_and_a_target_that_exist(self):
        configure, build = re.findall(r"^cmake --(?:preset|build) .*\n", self.build_lines, re.M)
        self.run_lines(f"cd '{SOURCE}'\n" + configure, {"--preset headless": f"--preset headless -B '{self.folder}/build'"})
        target = re.fullmatch(r"cmake --build --preset headless -- (\S+)\n", build)[1]
        self.assertIn(f"{target}:", self.run_lines(f"ninja -C build -t query {target}\n", {}))

    def test_readme_installs_what_run_sh_builds(self):
        readme = pathlib.Path(SOURCE, "README.md").read_text()
        line, = re.findall(r"^cmake --install .*--component embed.*\n", readme, re.M)
        self.assertIn("build/release ", line)
        built = re.search(r"^targets=\((.*)\)$", pathlib.Path(SOURCE, "run.sh").read_text(), re.M)[1].split()
        self.assertIn("lodestream_library", built)
        self.run_lines(line, {"build/release": BUILD, "/usr/local": str(self.folder / "usr")})
        self.assertTrue((self.folder / "usr" / "include" / "lodestream.h").exists())


if __name__ == "__main__":
    unittest.main()
