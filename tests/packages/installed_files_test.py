#!/usr/bin/env python3
"""Tests the files that are installed with the programs: installed_files_test.py BUILD"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

PACKAGING = pathlib.Path(__file__).resolve().parents[2] / "cmake" / "packaging"
PROGRAMS = ("lodestream", "lodestreamd")
OPTION = re.compile(r"(?<!\S)(?:-\w, *)?(--[a-z][a-z-]*)")
XMLNS = "{http://www.freedesktop.org/standards/shared-mime-info}"


def said(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=True, **options).stdout


def help_of(program, *command):
    return said(BUILD / "bin" / program, *command, "--help")


def commands_of(program):
    return re.findall(r"^  ([a-z]+)", help_of(program).split("Subcommands:", 1)[1], re.M)


def options_of(program, command):
    """Returns the long options of a command. In its help each begins a line, possibly after a short option."""
    return set(re.findall(r"^ +(?:-\w, *)?(--[a-z][a-z-]*)", help_of(program, command), re.M))


def texts_of(program, command):
    """Returns the help texts of a command's options and arguments: the text beside or below each name."""
    lines = [line.strip() for line in help_of(program, command).splitlines() if re.match(r" {20,}\S|  .*\S {2,}\S", line)]
    return {re.split(" {2,}", line)[-1] for line in lines}


def section_of(page, command):
    """Text of a command's section in a man page, without the escapes."""
    match = re.search(rf"^\.SS {command}\b(.*?)(?=^\.S[SH] )", page, re.M | re.S)
    text = match.group(1) if match else ""
    for escaped, plain in (("\\-", "-"), ("\\fB", ""), ("\\fR", ""), ("\\&", ""), ("\\e", "\\")):
        text = text.replace(escaped, plain)
    return text


def keys_of(name):
    """Keys of a desktop entry or a unit; a key that occurs again replaces the first."""
    text = (PACKAGING / name).read_text().replace("\\\n", " ")
    return dict(line.split("=", 1) for line in text.splitlines() if "=" in line and not line.startswith("#"))


class ManPages(unittest.TestCase):
    def page(self, program):
        return (BUILD / f"{program}.1").read_text()

    def test_have_a_section_of_every_command_with_all_its_options(self):
        for program in PROGRAMS:
            page = self.page(program)
            for command in commands_of(program):
                with self.subTest(program=program, command=command):
                    section = section_of(page, command)
                    self.assertNotEqual(section, "")
                    described = set(re.findall(r"^(?:-\w, )?(--[a-z][a-z-]*)", section, re.M))
                    self.assertEqual(described, options_of(program, command))

    def test_have_the_whole_text_of_the_help(self):
        for program in PROGRAMS:
            for command in commands_of(program):
                lines = set(section_of(self.page(program), command).splitlines())
                self.assertEqual(texts_of(program, command) - lines, set(), command)

    def test_depend_on_the_help_alone(self):
        for program in PROGRAMS:
            version = said(BUILD / "bin" / program, "--version").split()[1]
            again = said(PACKAGING / "make_man_page.sh", BUILD / "bin" / program, version, PACKAGING / f"{program}.man",
                         env={"PATH": "/usr/bin:/bin", "LC_ALL": "C", "TZ": "Pacific/Auckland"})
            self.assertEqual(again, self.page(program))

    @unittest.skipUnless(shutil.which("man"), "man comes with Debian's package man-db")
    def test_have_no_mistakes(self):
        for program in PROGRAMS:
            done = subprocess.run(["man", "--warnings", "-l", BUILD / f"{program}.1"], capture_output=True, text=True, check=True)
            self.assertEqual(done.stderr, "")


class Completion(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def offers(self, *words):
        """Returns the completions that bash offers for the last word."""
        script = """source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
            _lodestream "$1" "${!#}" "${COMP_WORDS[COMP_CWORD - 1]}"; printf '%s\\n' "${COMPREPLY[@]}" """
        offered = said("bash", "-c", script, PACKAGING / "completion.bash", BUILD / "bin" / words[0], *words[1:], cwd=self.folder)
        return {line for line in offered.splitlines() if line}

    def test_offers_every_command(self):
        for program in PROGRAMS:
            self.assertEqual(self.offers(program, ""), set(commands_of(program)))

    def test_offers_every_option_of_a_command(self):
        for program in PROGRAMS:
            for command in commands_of(program):
                with self.subTest(program=program, command=command):
                    self.assertEqual(self.offers(program, command, "--"), options_of(program, command))

    def test_offers_the_values_of_an_option(self):
        for words in (["--simplifier", "c"], ["--simplifier", "=", "c"], ["--simplifier", "="]):
            self.assertEqual(self.offers("lodestreamd", "build", *words), {"collapse", "cluster"})
        self.assertEqual(self.offers("lodestreamd", "build", "--threads", ""), set())

    def test_offers_files_that_the_command_reads(self):
        for name in ("a scan.ply", "B.PLY", "a.lode", "s.json", "notes.txt", "in/x.ply"):
            (self.folder / name).parent.mkdir(exist_ok=True)
            (self.folder / name).touch()
        for words, expected in (
            (["lodestreamd", "build", ""], {"a scan.ply", "B.PLY", "in"}),
            (["lodestreamd", "build", "in/"], {"in/x.ply"}),
            (["lodestreamd", "serve", ""], {"a.lode", "in"}),
            (["lodestream", "fetch", ""], {"a scan.ply", "B.PLY", "a.lode", "s.json", "in"}),
            (["lodestream", "B"], {"B.PLY"}),
            (["lodestreamd", "build", "--tmp", ""], {"in"}),
            (["lodestreamd", "serve", "--token-file", "n"], {"notes.txt"}),
        ):
            self.assertEqual(self.offers(*words), expected, words)


class Desktop(unittest.TestCase):
    def types(self):
        return {found.get("type"): found for found in xml.etree.ElementTree.parse(PACKAGING / "lodestream.xml").iter()
                if found.tag in (f"{XMLNS}mime-type", f"{XMLNS}alias")}

    def magic_of(self, kind):
        values = [match.get("value") for match in self.types()[kind].iter(f"{XMLNS}match")]
        return tuple(value.encode().decode("unicode_escape").encode("latin-1") for value in values)

    def test_entry_runs_a_command_that_takes_a_file(self):
        program, command, file = keys_of("lodestream.desktop")["Exec"].split()
        self.assertEqual((program, file), ("lodestream", "%f"))
        self.assertIn(command, commands_of(program))

    def test_entry_opens_the_types_that_are_declared(self):
        named = keys_of("lodestream.desktop")["MimeType"]
        self.assertTrue(named.endswith(";"))
        self.assertEqual(set(named.split(";")) - {""}, set(self.types()))

    @unittest.skipUnless(shutil.which("desktop-file-validate"), "comes with Debian's package desktop-file-utils")
    def test_entry_is_valid(self):
        self.assertEqual(said("desktop-file-validate", PACKAGING / "lodestream.desktop"), "")

    def test_types_match_the_files_that_the_programs_write(self):
        with tempfile.TemporaryDirectory() as folder:
            mesh, store = pathlib.Path(folder, "a.ply"), pathlib.Path(folder, "a.lode")
            said(BUILD / "bin/lodestreamd", "sample", "asteroid", "--triangles", "500", "-o", mesh)
            said(BUILD / "bin/lodestreamd", "build", mesh, "-o", store, "--quiet")
            self.assertTrue(mesh.read_bytes().startswith(self.magic_of("model/x-ply")))
            self.assertTrue(store.read_bytes().startswith(self.magic_of("model/vnd.lodestream")))


class Unit(unittest.TestCase):
    def test_commands_have_only_options_of_serve(self):
        for name in ("lodestreamd.service", "public.conf"):
            command = keys_of(name)["ExecStart"]
            self.assertTrue(command.startswith("lodestreamd serve /srv/models "), command)
            self.assertLessEqual(set(OPTION.findall(command)), options_of("lodestreamd", "serve"))


class Installation(unittest.TestCase):
    def test_has_what_the_operator_and_the_desktop_look_for(self):
        with tempfile.TemporaryDirectory() as folder:
            said("cmake", "--install", BUILD, "--component", "programs", "--prefix", folder)
            found = {str(path.relative_to(folder)) for path in pathlib.Path(folder).rglob("*") if path.is_file()}
        expected = {"lib/systemd/system/lodestreamd.service", "share/doc/lodestreamd/examples/public.conf",
                    "share/mime/packages/lodestream.xml", "share/icons/hicolor/scalable/apps/lodestream.svg"}
        for program in PROGRAMS:
            expected |= {f"bin/{program}", f"share/man/man1/{program}.1", f"share/bash-completion/completions/{program}",
                         f"share/doc/{program}/copyright"}
        self.assertEqual(found - {"share/applications/lodestream.desktop"}, expected)


if __name__ == "__main__":
    BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
