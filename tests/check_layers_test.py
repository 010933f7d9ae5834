#!/usr/bin/env python3
"""Tests that the layer check refuses forbidden includes and nothing else."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
from check_layers import complaints_about  # noqa: E402

CHECK = Path(__file__).with_name("check_layers.py")


def complaints(path, *includes):
    return list(complaints_about(path, "".join(f"#include {name}\n" for name in includes)))


class LayerCheck(unittest.TestCase):
    def test_accepts_the_layers_below(self):
        self.assertEqual(complaints("server/ingest/pipeline/build.cpp", '"server/store/writer.h"', '"common/mesh.h"'), [])
        self.assertEqual(complaints("client/core/session/session.cpp", '"proto/messages.h"', "<vector>"), [])
        self.assertEqual(complaints("client/app/cli/view.cpp", '"client/net/connection.h"'), [])

    def test_refuses_a_layer_above(self):
        self.assertEqual(len(complaints("common/mesh.h", '"proto/frame.h"')), 1)
        self.assertEqual(len(complaints("server/store/reader.cpp", '"server/ingest/pipeline/build.h"')), 1)
        self.assertEqual(len(complaints("client/core/lod/refiner.cpp", '"client/render/renderer.h"')), 1)

    def test_refuses_a_later_folder_of_the_build(self):
        self.assertEqual(complaints("server/ingest/nodes/node_builder.h", '"server/ingest/simplify/collapse.h"'), [])
        self.assertEqual(len(complaints("server/ingest/simplify/collapse.h", '"server/ingest/nodes/node_builder.h"')), 1)

    def test_refuses_server_in_client_and_client_in_server(self):
        self.assertEqual(len(complaints("client/app/cli/fetch.cpp", '"server/store/reader.h"')), 1)
        self.assertEqual(len(complaints("server/app/serve.cpp", '"client/core/view/view.h"')), 1)

    def test_refuses_the_transport_in_the_message_layer_and_in_the_core(self):
        self.assertEqual(len(complaints("proto/messages.cpp", '"proto/frame_stream.h"')), 1)
        self.assertEqual(len(complaints("client/core/session/session.h", '"proto/frame_stream.h"')), 1)

    def test_confines_libraries_to_their_layers(self):
        for library, home, elsewhere in [
            ("<GLFW/glfw3.h>", "client/app/window/window.cpp", "client/app/cli/view.cpp"),
            ("<epoxy/gl.h>", "client/render/renderer.cpp", "client/core/lod/cut.h"),
            ("<imgui.h>", "client/app/window/panel/panel.cpp", "client/net/connection.cpp"),
            ("<backends/imgui_impl_glfw.h>", "client/app/window/window.cpp", "client/app/cli/view.cpp"),
            ("<asio.hpp>", "proto/frame_stream.h", "proto/frame.h"),
            ("<asio/ip/tcp.hpp>", "server/serve/session/session.cpp", "server/store/reader.cpp"),
            ('"flatbuffers/flatbuffers.h"', "proto/messages.cpp", "server/serve/session/session.cpp"),
            ('"proto/lodestream_generated.h"', "proto/messages.cpp", "client/net/connection.cpp"),
            ("<draco/mesh/mesh.h>", "common/codec/draco_codec.cpp", "common/mesh.h"),
        ]:
            with self.subTest(library):
                self.assertEqual(complaints(home, library), [])
                self.assertEqual(len(complaints(elsewhere, library)), 1)

    def test_refuses_relative_includes_and_includes_of_tests(self):
        self.assertEqual(len(complaints("server/store/reader.cpp", '"../ingest/build.h"')), 1)
        self.assertEqual(len(complaints("server/main.cpp", '"tests/support/mesh.h"')), 1)

    def test_names_the_line_of_an_include_with_any_spacing(self):
        text = '#pragma once\n\n#  include   "client/core/view/view.h"\n// #include "client/net/a.h"\n'
        self.assertEqual(
            list(complaints_about("server/main.cpp", text)),
            ["server/main.cpp:3: client/core/view/view.h: layer server_app must not use layer core"],
        )

    def test_exit_status_tells_whether_the_tree_is_clean(self):
        with tempfile.TemporaryDirectory() as folder:
            header = Path(folder, "common", "mesh.h")
            header.parent.mkdir()
            header.write_text("#include <vector>\n")
            self.assertEqual(self.run_check(folder), 0)
            header.write_text('#include "proto/frame.h"\n')
            self.assertEqual(self.run_check(folder), 1)
            self.assertEqual(self.run_check(folder + "/nowhere"), 2)

    @staticmethod
    def run_check(folder):
        return subprocess.run([sys.executable, CHECK, folder], capture_output=True, check=False).returncode


if __name__ == "__main__":
    unittest.main()
