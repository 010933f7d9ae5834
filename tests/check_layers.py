#!/usr/bin/env python3
"""Checks every #include against the layers of docs/architecture.md.

usage: check_layers.py ROOT

Prints one line for each forbidden include and exits with 1 if there is any. cmake/LodeTarget.cmake checks what links against
what; this script checks headers, which a linker does not see.
"""

import re
import sys
from pathlib import Path

LAYERS_FILE = Path(__file__).parent.parent / "cmake" / "layers.txt"


def read_layers(path):
    """Reads cmake/layers.txt: (prefix, layer) pairs, longest prefix first; allowed layers; folders of the build in order."""
    layer_of, allowed, flow = [], {}, []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line or line.startswith("#"):
            continue
        name, *fields = (field.strip() for field in line.split("|"))
        if name.startswith("flow "):
            flow = fields[0].split()
            continue
        layer_of += [(prefix, name) for prefix in fields[0].split()]
        allowed[name] = {name, *fields[1].split()}
    return sorted(layer_of, key=lambda entry: -len(entry[0])), allowed, flow


LAYER_OF, ALLOWED, INGEST_FLOW = read_layers(LAYERS_FILE)

# Libraries that only some files may include: name, pattern of the include, path prefixes of those files.
CONFINED = [
    ("OpenGL and GLFW", re.compile(r"(GL|GLES\w*|KHR|EGL|GLFW|epoxy|imgui)/|(backends/)?(imgui|glad)\w*\.h$"),
     ("client/render/", "client/app/window/")),
    ("Asio", re.compile(r"(boost/)?asio(\.hpp$|/)"),
     ("proto/byte_stream", "proto/frame_stream", "server/serve/", "server/app/", "server/main",
      "client/net/", "client/app/", "client/loadtest/", "client/main")),
    ("CLI11", re.compile(r"CLI/"),
     ("common/command_line", "server/app/", "server/main", "client/app/", "client/loadtest/", "client/main")),
    ("FlatBuffers", re.compile(r"flatbuffers/|.*_generated\.h$"), ("proto/",)),
    ("Draco", re.compile(r"draco/"), ("common/codec/draco_",)),
]

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*["<]([^">]+)[">]', re.MULTILINE)


def layer_of(path):
    """The layer of a path from the root, or None for a library's header."""
    return next((layer for prefix, layer in LAYER_OF if path.startswith(prefix)), None)


def ingest_folder(path):
    """The folder of server/ingest that a path lies in, or None."""
    parts = path.split("/")
    return parts[2] if parts[:2] == ["server", "ingest"] and len(parts) == 4 else None


def breaks_the_flow(path, included):
    """Returns whether a file of server/ingest includes one of a later folder."""
    own, other = ingest_folder(path), ingest_folder(included)
    return own is not None and other is not None and INGEST_FLOW.index(other) > INGEST_FLOW.index(own)


def complaints_about(path, text):
    """One line for each forbidden include of the file at `path` (from the root, with slashes)."""
    own = layer_of(path)
    for match in INCLUDE.finditer(text):
        included = match.group(1)
        where = f"{path}:{text.count(chr(10), 0, match.start(1)) + 1}: {included}"
        if included.startswith((".", "/")):
            yield f"{where}: name headers from the root of the repository"
            continue
        layer = layer_of(included)
        if layer is not None and layer not in ALLOWED[own]:
            yield f"{where}: layer {own} must not use layer {layer}"
        if breaks_the_flow(path, included):
            yield f"{where}: {ingest_folder(path)} comes before {ingest_folder(included)} in the build"
        if included.startswith("tests/"):
            yield f"{where}: only tests may use tests"
        for library, pattern, homes in CONFINED:
            if pattern.match(included) and not path.startswith(homes):
                yield f"{where}: {library} only in {', '.join(home + '*' for home in homes)}"


def sources(root):
    for top in ("common", "proto", "server", "client"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix in (".h", ".cpp"):
                yield path


def main(arguments):
    if len(arguments) != 2 or not Path(arguments[1], "common").is_dir():
        print(__doc__, file=sys.stderr)
        return 2
    root = Path(arguments[1])
    count = 0
    complaints = []
    for path in sources(root):
        count += 1
        complaints += complaints_about(path.relative_to(root).as_posix(), path.read_text(encoding="utf-8"))
    for complaint in complaints:
        print(complaint)
    print(f"layers: {count} files, {len(complaints)} forbidden includes", file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
