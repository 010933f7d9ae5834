#!/usr/bin/env python3
"""Tests that docker/install-packages.sh installs missing packages and nothing else."""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parent.parent / "docker" / "install-packages.sh"
TOOLS = ("bash", "awk", "grep", "tr", "dirname", "env", "cat", "mkdir", "mktemp", "rm")
NO_NETWORK = "printf 'Err:1 http://deb.example bookworm InRelease\\n  Cannot resolve deb.example\\n'"


class InstallPackages(unittest.TestCase):
    """Runs the script with a PATH of its own, where apt and dpkg are stubs that record their calls."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        for tool in TOOLS:
            (self.folder / tool).symlink_to(shutil.which(tool))
        shutil.copytree(SCRIPT.parent, self.folder / "docker")
        self.listed("# a comment\n[run]\nlibone  # why\n\n[build]\nlibone\ntool\n[test]\nother\n")
        self.calls = self.folder / "calls"
        self.calls.touch()
        self.fake("apt-get", f'echo "apt-get $*" >> {self.calls}')
        self.offered("libone", "tool", "other")
        self.fake("sudo", f'echo "sudo" >> {self.calls}; exec "$@"')
        self.installed("libone", "tool", "other")

    def fake(self, name, body):
        path = self.folder / name
        path.write_text(f"#!{shutil.which('bash')}\n{body}\n")
        path.chmod(0o755)

    def installed(self, *names):
        cases = "|".join(names) or "-"
        self.fake("dpkg-query", f"case \"${{!#}}\" in {cases}) printf 'installed ';; *) printf 'not-installed '; exit 1;; esac")

    def offered(self, *names):
        cases = "|".join(names)
        self.fake("apt-cache", f"case \"${{!#}}\" in {cases}) echo '  Candidate: 1.0';; *) echo '  Candidate: (none)';; esac")

    def listed(self, text):
        (self.folder / "docker" / "packages.txt").write_text(text)

    def run_script(self, *sections, identity=None, **environment):
        return subprocess.run(
            [self.folder / "docker" / "install-packages.sh", *sections],
            env={"PATH": str(self.folder), **environment}, capture_output=True, text=True, check=False, **(identity or {}),
        )

    def apt_calls(self):
        return [line for line in self.calls.read_text().splitlines() if line.startswith("apt-get")]

    def test_does_not_call_apt_if_all_packages_are_installed(self):
        self.assertEqual(self.run_script("run", "build", "test").returncode, 0)
        self.assertEqual(self.apt_calls(), [])

    def test_installs_only_missing_packages_of_the_named_sections(self):
        self.installed("libone")
        self.assertEqual(self.run_script("run", "build").returncode, 0)
        update, install = self.apt_calls()
        self.assertIn("update", update)
        self.assertTrue(install.endswith("--no-install-recommends tool"), install)

    def test_installs_the_first_alternative_that_apt_offers(self):
        self.listed("[run]\nlibnine | libeight | libseven  # why\n")
        self.installed()
        self.offered("libeight", "libseven")
        self.assertEqual(self.run_script("run").returncode, 0)
        self.assertTrue(self.apt_calls()[1].endswith("--no-install-recommends libeight"), self.apt_calls())

    def test_reads_long_output_of_apt_cache_to_its_end(self):
        self.listed("[run]\nlibnine | libeight\n")
        self.installed()
        self.fake("apt-cache", 'case "${!#}" in libeight) echo "  Candidate: 1.0"; for _ in {1..20000}; do '
                  'echo "  Version table:" || exit 1; done;; *) echo "  Candidate: (none)";; esac')
        self.assertEqual(self.run_script("run").returncode, 0)
        self.assertTrue(self.apt_calls()[1].endswith("--no-install-recommends libeight"), self.apt_calls())

    def test_accepts_any_installed_alternative(self):
        self.listed("[run]\nlibnine | libeight | libseven\n")
        self.installed("libseven")
        self.assertEqual(self.run_script("run").returncode, 0)
        self.assertEqual(self.apt_calls(), [])

    def test_passes_the_first_name_to_apt_if_apt_offers_no_alternative(self):
        self.listed("[run]\nlibnine | libeight\n")
        self.installed()
        self.fake("apt-get", f'echo "apt-get $*" >> {self.calls}; [[ $1 == update ]]')
        self.assert_one_line_failure(self.run_script("run"), "could not install all of: libnine", lines=2)

    def test_continues_if_apt_cannot_update_its_lists(self):
        self.installed()
        self.fake("apt-get", f'echo "apt-get $*" >> {self.calls}; [[ $1 != update ]]')
        self.assertEqual(self.run_script("test").returncode, 0)
        self.assertEqual(len(self.apt_calls()), 2)

    def test_fails_when_a_package_cannot_be_installed(self):
        self.installed()
        self.fake("apt-get", "[[ $1 == update ]]")
        self.assert_one_line_failure(self.run_script("test"), "could not install all of: other", lines=2)

    def test_refuses_an_unknown_section(self):
        self.assert_one_line_failure(self.run_script("run", "bild"), "no section [bild]")

    def test_says_what_to_do_on_a_system_without_dpkg(self):
        (self.folder / "dpkg-query").unlink()
        self.assert_one_line_failure(self.run_script("run"), "LODESTREAM_PACKAGES=skip")
        self.assertEqual(self.run_script("run", LODESTREAM_PACKAGES="skip").returncode, 0)

    def test_names_the_missing_packages_without_apt(self):
        self.installed()
        (self.folder / "apt-get").unlink()
        self.assert_one_line_failure(self.run_script("run", "test"), "libone other")

    def test_names_itself_as_remedy_without_root_and_sudo(self):
        self.installed()
        (self.folder / "sudo").unlink()
        self.folder.chmod(0o755)
        identity = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
        self.assert_one_line_failure(self.run_script("run", "test", identity=identity),
                                     f"packages are missing: 2; as root, run: {self.folder}/docker/install-packages.sh run test")

    def test_says_only_that_there_is_no_network(self):
        self.installed()
        for status in (0, 100):  # apt-get update does not always fail
            self.fake("apt-get", f'echo "apt-get $*" >> {self.calls}; {NO_NETWORK}; exit {status}')
            self.assert_one_line_failure(self.run_script("run"), "no network: apt reaches no package mirror "
                                         "(Cannot resolve deb.example), and packages are missing: 1; ")
        self.assertNotIn(" install ", self.calls.read_text())

    def test_continues_if_one_of_two_mirrors_answers(self):
        self.installed()
        self.fake("apt-get", f'echo "apt-get $*" >> {self.calls}; {NO_NETWORK}; echo "Hit:2 http://b.example bookworm InRelease"')
        self.assertEqual(self.run_script("run").returncode, 0)
        self.assertIn(" install ", self.calls.read_text())

    def test_plans_without_installing(self):
        self.fake("apt-get", f"""echo "apt-get $*" >> {self.calls}
            echo '0 upgraded, 9 newly installed, 0 to remove and 5 not upgraded.'
            echo 'Need to get 1,024 kB/2 MB of archives.'
            echo 'After this operation, 3 MB of additional disk space will be used.'""")
        self.assertEqual(self.run_script("--plan", "run").stdout, "")
        self.installed()
        self.assertIn("9 packages (1,024 kB to download, 3 MB on disk) ", self.run_script("--plan", "run").stdout)
        installs = [call for call in self.apt_calls() if " install " in call]
        self.assertTrue(installs and all("--print-uris" in call for call in installs), installs)

    def assert_one_line_failure(self, result, text, lines=1):
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), lines, result.stderr)
        self.assertIn(text, result.stderr.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
