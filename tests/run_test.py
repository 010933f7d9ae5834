#!/usr/bin/env python3
"""Tests run.sh for a new user: refused files, the first line, packages, the build, the window or a picture."""

import contextlib
import os
import re
import shutil
import socket
import subprocess
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parent.parent / "run.sh"
NEITHER = ", neither a PLY file nor a store; "
ZEROES = bytes(80)
WEB_PORT = 7480
INSTALLER = SCRIPT.parent / "docker" / "install-packages.sh"
TOOLS = ("awk", "basename", "bash", "cat", "cp", "dirname", "env", "find", "grep", "id", "mkdir", "mktemp", "mv", "nproc", "od", "rm",
         "sed", "stat", "tr")
IS_ROOT = os.geteuid() == 0
USER = 65534


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
        self.assert_refused("/dev/null", "/dev/null is a pipe or a device; name a file: a store or a PLY")
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


class FirstRun(unittest.TestCase):
    """Runs copies of run.sh and the installer with a PATH of its own, where apt, sudo, cmake and the programs are
    fakes that record their calls. As root, the test plays another user, because root may write everywhere."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.folder.chmod(0o755)
        self.checkout = self.folder / "checkout"
        self.build = self.checkout / "build" / "release"
        (self.checkout / "docker").mkdir(parents=True)
        shutil.copy(SCRIPT, self.checkout)
        shutil.copy(INSTALLER, self.checkout / "docker")
        (self.checkout / "docker" / "packages.txt").write_text("[run]\nlibnew | libold\n[window]\nlibgl\n[build]\ntool\n")
        for name in ("CMakeLists.txt", "CMakePresets.json"):
            (self.checkout / name).touch()
        for name in ("cmake", "common", "proto", "server", "client"):
            (self.checkout / name).mkdir()
        (self.checkout / "scan.ply").write_text("ply\n")
        self.calls = self.folder / "calls"
        self.calls.touch()
        self.path = self.folder / "bin"
        self.path.mkdir()
        for tool in TOOLS:
            (self.path / tool).symlink_to(shutil.which(tool))
        self.fake("dpkg-query", f"[[ -e {self.folder}/installed ]] && echo 'installed '")
        self.fake("sudo", 'exec "$@"')
        self.fake("apt-cache", f"[[ -e {self.folder}/lists ]] && [[ ${{!#}} == libold ]] && echo '  Candidate: 1.0'")
        self.fake("apt-get", f"""
            case "$*" in
              *update*) echo 'Get:1 http://deb.example bookworm InRelease' ;;
              *--print-uris*)
                echo 'Reading package lists...'
                [[ -e {self.folder}/lists || "$1" == -c ]] || exit 100
                echo '1 upgraded, 3 newly installed, 0 to remove and 5 not upgraded.'
                echo 'Need to get 13.2 MB of archives.'
                echo 'After this operation, 50.3 MB of additional disk space will be used.'
                ;;
              *install*) echo "apt-get $*" >> {self.calls}; : > {self.folder}/installed ;;
            esac""")
        self.fake("cmake", f"""
            echo "cmake $*" >> {self.calls}
            if [[ $1 == --build ]]; then
              mkdir -p "$2/bin"
              cp {self.path}/program "$2/bin/lodestream"
              cp {self.path}/program "$2/bin/lodestreamd"
            else
              : > build/release/build.ninja
              echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" > build/release/CMakeCache.txt
            fi""")
        self.fake("program", f"""
            echo "${{0##*/}} $*" >> {self.calls}
            case "$1" in
              sample) echo ply > "${{!#}}" ;;
              store) echo "/kept/${{2##*/}}.lode" ;;
              serve) echo '{{"http":"127.0.0.1:1","link":"http://127.0.0.1:1/#model=a%20b","models":["a b"]}}' ;;
            esac""")
        (self.folder / "lists").touch()
        self.give_to_user(self.folder)

    def fake(self, name, body):
        path = self.path / name
        path.write_text(f"#!{shutil.which('bash')}\n{body}\n")
        path.chmod(0o755)

    def give_to_user(self, folder):
        if IS_ROOT:
            for path in (folder, *folder.rglob("*")):
                os.chown(path, USER, USER, follow_symlinks=False)

    def take_from_user(self, folder):
        """Makes a folder and what is in it unwritable for the user."""
        self.addCleanup(lambda: folder.is_dir() and subprocess.run(["chmod", "-R", "u+w", folder], check=True))
        if IS_ROOT:
            for path in (folder, *folder.rglob("*")):
                os.chown(path, 0, 0, follow_symlinks=False)
        else:
            subprocess.run(["chmod", "-R", "a-w", folder], check=True)

    def run_script(self, *words, as_root=False, **environment):
        identity = {"user": USER, "group": USER, "extra_groups": []} if IS_ROOT and not as_root else {}
        variables = {"PATH": str(self.path), "HOME": str(self.folder / "home"), **environment}
        return subprocess.run([self.path / "bash", "run.sh", *words], cwd=self.checkout, env=variables, check=False,
                              capture_output=True, text=True, **identity)

    def calls_of(self, program):
        return [line for line in self.calls.read_text().splitlines() if line.split()[0] == program]

    def have_packages(self):
        (self.folder / "installed").touch()

    def have_programs(self):
        """Builds the programs and forgets the calls."""
        self.have_packages()
        self.assertEqual(self.run_script("scan.ply").returncode, 0)
        self.calls.write_text("")

    def change(self, source):
        os.utime(self.checkout / source, (2e9, 2e9))

    def assert_shows(self, words, command, **environment):
        result = self.run_script(*words, **environment)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(self.calls_of("lodestream"), [f"lodestream {command}"])
        return result

    def assert_fails(self, text, *words, **environment):
        """Fails in one line, before it installs or builds anything."""
        result = self.run_script(*words, **environment)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertRegex(result.stderr, text)
        self.assertEqual(self.calls.read_text(), "")

    def test_says_first_what_it_will_do(self):
        result = self.run_script("scan.ply")
        self.assertEqual(result.returncode, 0, result.stderr)
        first = result.stderr.splitlines()[0]
        self.assertRegex(first, r"^run\.sh: installs 4 packages \(13\.2 MB to download, 50\.3 MB on disk\) with sudo, "
                         r"then compiles for about \d+ minutes? in .*/build/release; later runs need neither$")
        install, = self.calls_of("apt-get")
        self.assertTrue(install.endswith("--no-install-recommends libold libgl tool"), install)

    @unittest.skipUnless(IS_ROOT, "needs root")
    def test_says_that_it_installs_as_root(self):
        self.assertIn("50.3 MB on disk) as root, then", self.run_script("scan.ply", as_root=True).stderr.splitlines()[0])

    def test_says_only_the_first_time_that_it_compiles_for_minutes(self):
        self.have_packages()
        first = self.run_script("scan.ply").stderr.splitlines()[0]
        self.assertRegex(first, r"^run\.sh: compiles for about \d+ minutes? in .*/build/release, the first time only$")
        again = self.run_script("scan.ply").stderr
        self.assertNotIn("compiles", again)
        self.assertNotIn("the first time", again)
        self.change("server")
        self.assertIn("run.sh: compiles what has changed in ", self.run_script("scan.ply").stderr)

    def test_configures_only_if_it_must(self):
        self.have_programs()
        self.run_script("scan.ply")
        self.assertEqual([call.split()[1] for call in self.calls_of("cmake")], ["--build"])
        self.change("CMakePresets.json")
        self.calls.write_text("")
        self.run_script("scan.ply")
        self.assertEqual([call.split()[1] for call in self.calls_of("cmake")], ["--preset", "--build"])

    def test_says_first_that_there_is_no_network(self):
        self.fake("apt-get", f"""
            if [[ "$*" == *update* ]]; then
              printf 'Err:1 http://deb.example bookworm InRelease\\n  Cannot resolve deb.example\\nReading package lists...\\n'
            else
              echo "apt-get $*" >> {self.calls}
              exit 100
            fi""")
        result = self.run_script("scan.ply")
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr, "install-packages: no network: apt reaches no package mirror (Cannot resolve deb.example),"
                         " and packages are missing: 3; connect this machine and try again\n")
        self.assertEqual([call for call in self.calls_of("apt-get") if "--print-uris" not in call], [])

    def test_knows_the_sizes_if_the_lists_of_apt_are_empty(self):
        (self.folder / "lists").unlink()
        self.assertIn("installs 4 packages (13.2 MB to download", self.run_script("scan.ply").stderr.splitlines()[0])

    def test_names_the_installer_as_remedy_without_root_and_sudo(self):
        (self.path / "sudo").unlink()
        for lists in ("full", "empty"):
            with self.subTest(lists):
                if lists == "empty":
                    (self.folder / "lists").unlink()
                self.assert_fails(r"^install-packages: .* root nor sudo, .* missing: 3; as root, run: "
                                  r"\S+/checkout/docker/install-packages\.sh run window build$", "scan.ply")

    def test_uses_current_programs_of_a_build_that_it_cannot_write(self):
        self.have_programs()
        self.take_from_user(self.checkout / "build")
        result = self.run_script()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"^run\.sh: \S+/build\S* cannot be written by .*: uses the programs that are there; "
                         "they are current\n")
        self.assertEqual(self.calls_of("cmake"), [])
        sample = self.folder / "home" / ".cache" / "lodestream" / "sample" / "asteroid.ply"
        picture = self.folder / "home" / ".cache" / "lodestream" / "asteroid.png"
        self.assertEqual(self.calls_of("lodestream"), [f"lodestream render {sample} -o {picture}"])
        self.assertEqual((self.folder / "home" / ".cache" / "lodestream").stat().st_mode & 0o777, 0o700)

    def test_refuses_to_build_where_it_cannot_write(self):
        self.have_programs()
        self.change("client")
        (self.build / "configure.log").write_text("an old log\n")
        self.take_from_user(self.build / "configure.log")
        self.assert_fails(r"^run\.sh: \S+/build/release/configure\.log cannot be written by \w+ \(it belongs to \w+\), and the "
                          r"programs are missing or not known to be current; remove \S+/build/release as \w+, or use a copy of your own: cp -r \S+ FOLDER$",
                          "scan.ply")

    def test_refuses_to_build_in_the_checkout_of_another_user(self):
        self.have_packages()
        self.take_from_user(self.checkout)
        self.assert_fails(r"^run\.sh: \S+/checkout cannot be written by \w+ \(it belongs to \w+\)", "scan.ply")

    @unittest.skipUnless(IS_ROOT, "needs root")
    def test_says_that_the_checkout_in_which_root_builds_belongs_to_another_user(self):
        self.have_packages()
        note = f"run.sh: {self.checkout} belongs to "
        self.assertIn(note, self.run_script("scan.ply", as_root=True).stderr.splitlines()[1])
        self.assertNotIn(note, self.run_script("scan.ply", as_root=True).stderr)

    def test_configures_a_moved_checkout_anew(self):
        self.have_programs()
        old = self.checkout
        self.checkout = self.checkout.rename(self.folder / "moved")
        result = self.run_script("scan.ply")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"run.sh: the checkout was built in {old}: configures anew\n", result.stderr)
        configured, built = self.calls_of("cmake")
        self.assertEqual(configured, "cmake --fresh --preset release -DLODE_TESTS=OFF")
        self.assertIn(f"--build {self.checkout}/build/release", built)

    def test_does_not_use_the_programs_of_a_moved_checkout_that_it_cannot_write(self):
        self.have_programs()
        self.checkout = self.checkout.rename(self.folder / "moved")
        self.take_from_user(self.checkout / "build")
        self.assert_fails("cannot be written by .*, and the programs are missing or not known to be current", "scan.ply")

    def test_prints_why_the_configuration_failed(self):
        self.have_packages()
        self.fake("cmake", "echo 'CMake Error: reason'; exit 1")
        result = self.run_script("scan.ply")
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr.splitlines()[1:], [
            "CMake Error: reason", "run.sh: cmake could not configure the build; the lines above say why"])

    def test_finds_the_model_among_options(self):
        self.have_programs()
        for before, after in ((["--size", "80x60"], []), (["--size=80x60", "--unlit"], []), (["--offline"], ["--pixels", "2"])):
            with self.subTest(before):
                self.calls.write_text("")
                self.assert_shows([*before, "scan.ply", *after], f"view scan.ply {' '.join(before + after)}", DISPLAY=":0")
        self.calls.write_text("")
        self.assert_fails("two models: scan.ply and b.ply; name one", "scan.ply", "--unlit", "b.ply")

    def test_knows_the_options_without_a_value(self):
        """A word after an option that run.sh does not know as a flag is the option's value, never the model."""
        known = re.search(r'^flags="([^"]*)"', SCRIPT.read_text(), re.MULTILINE)[1].split()
        client = SCRIPT.parent / "client" / "app"
        sources = [client / "cli" / "common_options.cpp", *(client / "window").glob("*_command.cpp"),
                   client / "window" / "look_options.cpp"]
        words = re.findall(r'(?:add_flag|add_flag_callback|set_version_flag)\(\s*"(--[a-z-]+)"',
                           "".join(source.read_text() for source in sources))
        self.assertEqual(sorted(known), sorted(set(words)))

    def test_draws_a_picture_if_one_is_named(self):
        self.have_programs()
        for words in (["-o", "a.png"], ["-oa.png"], ["--output=a.png"], ["--video", "a.mp4", "--fps", "25"], ["--frames", "out"]):
            with self.subTest(words):
                self.calls.write_text("")
                result = self.assert_shows(["scan.ply", *words], f"render scan.ply {' '.join(words)}", DISPLAY=":0")
                self.assertNotIn("no display", result.stderr)

    def test_draws_a_picture_without_a_display(self):
        self.have_programs()
        result = self.assert_shows(["scan.ply"], f"render scan.ply -o {self.checkout}/build/scan.png")
        self.assertIn("run.sh: no display here (DISPLAY is not set): draws a picture of scan.ply\n", result.stderr)

    def test_says_that_wayland_alone_gives_no_window(self):
        self.have_programs()
        result = self.assert_shows(["scan.ply"], f"render scan.ply -o {self.checkout}/build/scan.png", WAYLAND_DISPLAY="wayland-0")
        self.assertIn("run.sh: no X display here (DISPLAY is not set; the window needs Xwayland, package xwayland): "
                      "draws a picture of scan.ply\n", result.stderr)

    def test_refuses_options_of_the_window_without_one(self):
        self.assert_fails(r"^run\.sh: --fps needs --frames DIR or --video OUT\.mp4, or a window; no display here", "--fps", "30")
        self.assert_fails(r"^run\.sh: --laps needs a window; no display here", "scan.ply", "--laps", "2")
        self.assert_fails(r"^run\.sh: --no-fade needs a window; leave out -o", "-o", "a.png", "--no-fade", DISPLAY=":0")
        self.have_programs()
        self.assert_shows(["scan.ply", "--fps", "30"], "view scan.ply --fps 30", DISPLAY=":0")

    def assert_serves(self, words, shown, **environment):
        """Serves a store on this machine and prints the link. Returns the port of --http."""
        self.calls.write_text("")
        result = self.run_script("--web", *words, **environment)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"run.sh: http://127.0.0.1:1/#model=a%20b shows {shown} in a browser; Ctrl-C ends the server\n", result.stderr)
        self.assertEqual(self.calls_of("lodestream"), [f"lodestream store {shown}"])
        serve, = (call for call in self.calls_of("lodestreamd") if " serve " in call)
        command, port = serve.rsplit(":", 1)
        self.assertEqual(command, f"lodestreamd serve /kept/{Path(shown).name}.lode --listen 127.0.0.1:0 --http 127.0.0.1")
        return int(port)

    def test_serves_a_model_to_a_browser(self):
        self.have_programs()
        (self.checkout / "b.lode").write_bytes(b"LODE\r\n\x1a\n")
        self.assert_serves(["scan.ply"], "scan.ply")
        self.assert_serves(["b.lode"], "b.lode")
        self.assert_serves([], f"{self.checkout}/build/sample/asteroid.ply")

    def test_serves_on_another_port_if_its_own_is_taken(self):
        self.have_programs()
        with contextlib.suppress(OSError), socket.create_server(("127.0.0.1", WEB_PORT)):
            self.assertEqual(self.assert_serves(["scan.ply"], "scan.ply"), 0)
        with socket.socket() as free:
            free.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            with contextlib.suppress(OSError):
                free.bind(("127.0.0.1", WEB_PORT))  # nothing else can take it, and nothing listens
                self.assertEqual(self.assert_serves(["scan.ply"], "scan.ply"), WEB_PORT)

    def test_opens_the_link_where_it_can(self):
        self.have_programs()
        self.fake("xdg-open", f'echo "xdg-open $*" >> {self.calls}')
        for environment in ({"DISPLAY": ":0"}, {"WAYLAND_DISPLAY": "wayland-0"}):
            self.assert_serves(["scan.ply"], "scan.ply", **environment)
            self.assertEqual(self.calls_of("xdg-open"), ["xdg-open http://127.0.0.1:1/#model=a%20b"])
        self.assert_serves(["scan.ply"], "scan.ply")
        self.assertEqual(self.calls_of("xdg-open"), [])

    def test_ends_with_the_status_of_a_step_that_fails(self):
        self.have_programs()
        for step in ("store", "serve"):
            self.fake("program", f"[[ $1 != {step} ]] || {{ echo 'no space' >&2; exit 3; }}; echo /kept/a.lode")
            result = self.run_script("--web", "scan.ply")
            self.assertEqual((result.returncode, result.stderr), (3, "no space\n"), step)

    def test_refuses_what_a_browser_cannot_show(self):
        self.assert_fails(r"^run\.sh: no such file: gone\.ply", "--web", "gone.ply")
        self.assert_fails(r"^run\.sh: lode://host/m is on a server; --web shows a PLY file or a store", "--web", "lode://host/m")
        self.assert_fails(r"^run\.sh: --web takes no options; leave out --pixels 2", "scan.ply", "--web", "--pixels", "2")
        (self.checkout / "scene.json").write_text("{}")
        self.assert_fails(r"^run\.sh: scene\.json is a scene; --web shows one model", "--web", "scene.json")

    def test_prints_its_usage_wherever_help_is_asked(self):
        for words in (["--help"], ["scan.ply", "-h"]):
            result = self.run_script(*words)
            self.assertEqual((result.returncode, self.calls.read_text()), (0, ""), words)
            self.assertTrue(result.stdout.startswith("usage: ./run.sh"), words)


if __name__ == "__main__":
    unittest.main()
