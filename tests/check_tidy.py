#!/usr/bin/env python3
"""Runs clang-tidy 14 over the sources of the programs: tests/check_tidy.py [BUILD] [FILE...]

BUILD (build/dev) is a build folder with generated headers. Most of the time goes into headers, so the sources of a folder
with equal options are read as one: names in anonymous namespaces must differ within a folder. A using declaration that only
another source needs goes unnoticed.
"""

import collections
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

SOURCES = ["common/*.cpp", "proto/*.cpp", "server/*.cpp", "client/*.cpp"]
# The examples compile against an installed tree, the module with emscripten.
WITH_THEIR_OWN_BUILD = [":!client/embed/examples", ":!client/web/module"]
UNITY = re.compile(r"/Unity/unity_[^/]+\.cxx$")
CHATTER = re.compile(r"^\d+ warnings? (generated|treated)")


def all_sources():
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "--deduplicate",
                             "--", *SOURCES, *WITH_THEIR_OWN_BUILD], check=True, capture_output=True, text=True)
    return listed.stdout.split()


def sources_of(file):
    """Sources of a compiled file: those that a unity file includes, or the file itself."""
    if not UNITY.search(file):
        return [file]
    return re.findall(r'^#include "(.+)"$', pathlib.Path(file).read_text(), re.MULTILINE)


def read_commands(build):
    """Compile commands by file, without precompiled headers, which clang cannot read from g++."""
    commands = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        command = re.sub(r" -Winvalid-pch -include \S+", "", entry["command"])
        for file in sources_of(entry["file"]):
            commands[os.path.relpath(file)] = entry | {"file": file, "command": command.replace(entry["file"], file)}
    return commands


def together(files, commands):
    """Groups of files with one folder and equal options, the largest first."""
    groups = collections.defaultdict(list)
    for file in files:
        if file not in commands:
            sys.exit(f"check_tidy: no target compiles {file}; name it in a CMakeLists.txt and configure again")
        how = re.sub(r" -o .*", "", commands[file]["command"])
        groups[os.path.dirname(file), how].append(file)
    return sorted(groups.values(), key=len, reverse=True)


def complaints(commands_at, files):
    """Output of clang-tidy for the files; empty without complaints."""
    *before, last = files
    others = [f"--extra-arg={word}" for file in before for word in ("-include", os.path.abspath(file))]
    run = subprocess.run(["clang-tidy-14", "-p", commands_at, "--quiet", "--checks=-bugprone-suspicious-include",
                          *others, last],
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if run.returncode == 0:
        return ""
    return "".join(line for line in run.stdout.splitlines(keepends=True) if not CHATTER.match(line))


def main():
    build = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/dev").absolute()
    files = sorted({os.path.relpath(file) for file in sys.argv[2:]})
    os.chdir(pathlib.Path(__file__).resolve().parent.parent)
    if not (build / "compile_commands.json").is_file():
        sys.exit(f"check_tidy: no {build}/compile_commands.json; run: cmake --preset dev && cmake --build --preset dev")
    files = files or all_sources()
    commands = read_commands(build)
    groups = together(files, commands)
    print(f"tidy: {len(files)} files in {len(groups)} groups", flush=True)
    with tempfile.TemporaryDirectory() as commands_at, ThreadPoolExecutor(os.cpu_count()) as pool:
        (pathlib.Path(commands_at) / "compile_commands.json").write_text(json.dumps(list(commands.values())))
        said = "".join(pool.map(lambda group: complaints(commands_at, group), groups))
    print(said, end="")
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main())
