#!/usr/bin/env python3
"""Checks every #include against the layers of docs/architecture.md.

usage: check_layers.py ROOT

Prints one line for each forbidden include and exits 1 if there is any. What links against what is checked by
cmake/LodeTarget.cmake; this is about headers, which a linker does not see.
"""

import re
import sys
from pathlib import Path

# A file belongs to the first layer whose prefix its path has.
LAYER_OF = [
    ("common/mesh_images/", "mesh_images"),
    ("common/", "common"),
    ("proto/byte_stream", "frame_stream"),
    ("proto/frame_stream", "frame_stream"),
    ("proto/", "proto"),
    ("server/store/", "store"),
    ("server/ingest/", "ingest"),
    ("server/serve/", "serve"),
    ("server/", "server_app"),
    ("client/core/", "core"),
    ("client/net/", "net"),
    ("client/stream/", "stream"),
    ("client/embed/", "embed"),
    ("client/render/", "render"),
    ("client/app/window/", "window"),
    ("client/", "client_app"),
]

ALLOWED = {
    "common": {"common"},
    "mesh_images": {"mesh_images", "common"},
    "proto": {"proto", "common"},
    "frame_stream": {"frame_stream", "proto", "common"},
    "store": {"store", "mesh_images", "common"},
    "ingest": {"ingest", "store", "common"},
    "serve": {"serve", "store", "proto", "frame_stream", "common"},
    "server_app": {"server_app", "serve", "ingest", "store", "proto", "frame_stream", "common"},
    "core": {"core", "proto", "common"},
    "net": {"net", "core", "proto", "frame_stream", "common"},
    "stream": {"stream", "net", "core", "proto", "common"},
    "embed": {"embed", "stream", "net", "core", "proto", "common"},
    "render": {"render", "core", "mesh_images", "common"},
    "window": {"window", "client_app", "render", "stream", "net", "core", "proto", "frame_stream", "common"},
    "client_app": {"window", "client_app", "render", "stream", "net", "core", "mesh_images", "proto", "frame_stream",
                   "common"},
}

# The folders of server/ingest, as the build flows: each may use itself and those before it.
INGEST_FLOW = [
    "threads", "disk", "mesh", "plan", "ply", "soup", "textures", "partition", "simplify", "measure", "nodes", "build", "sample",
    "inspect",
]

# Libraries that only some files may include: name, pattern of the include, path prefixes of those files.
CONFINED = [
    ("OpenGL and GLFW", re.compile(r"(GL|GLES\w*|KHR|EGL|GLFW|epoxy|imgui)/|(backends/)?(imgui|glad)\w*\.h$"),
     ("client/render/", "client/app/window/")),
    ("Asio", re.compile(r"(boost/)?asio(\.hpp$|/)"),
     ("proto/byte_stream", "proto/frame_stream", "server/serve/", "server/app/", "server/main", "client/net/", "client/app/", "client/main")),
    ("CLI11", re.compile(r"CLI/"),
     ("common/command_line", "server/app/", "server/main", "client/app/", "client/main")),
    ("FlatBuffers", re.compile(r"flatbuffers/|.*_generated\.h$"), ("proto/",)),
    ("Draco", re.compile(r"draco/"), ("common/draco_",)),
]

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*["<]([^">]+)[">]', re.MULTILINE)


def layer_of(path):
    """The layer of a path from the root, or None for what is outside of the tree (a library)."""
    return next((layer for prefix, layer in LAYER_OF if path.startswith(prefix)), None)


def ingest_folder(path):
    """The folder of server/ingest that a path lies in, or None."""
    parts = path.split("/")
    return parts[2] if parts[:2] == ["server", "ingest"] and len(parts) == 4 else None


def breaks_the_flow(path, included):
    """Whether a file of server/ingest includes one of a later folder."""
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
