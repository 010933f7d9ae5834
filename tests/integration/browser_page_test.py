#!/usr/bin/env python3
"""Drives the page of `lodestreamd serve --http` in Chromium: browser_page_test.py BIN MODELS

Skipped without Chromium and its driver, or if the programs have no page.
"""
import base64
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import browser
from browser import Browser
from http_served import BIN, MODELS, Served

PAGE = pathlib.Path(__file__).resolve().parents[2] / "client" / "web" / "dist"
WIDTH, HEIGHT = 960, 540
CONVERGED = "window.lodestream && window.lodestream.state().converged && window.lodestream.state().settled"

# Counts the open edges of each list of parts from the core, in the vertex words that the page uploads.
WATCH_EDGES = """
const viewer = window.lodestream.viewer(), model = viewer.session.model, frame = model.frame.bind(model);
window.seen = [];
model.frame = (...input) => {
  const answer = frame(...input);
  if (answer.parts) window.seen.push({open: openEdges(answer.parts), parts: answer.parts});
  return answer;
};
function openEdges(parts) {
  const edges = new Set();
  for (const [id] of parts) {
    const words = model.meshVertices(id), indices = model.meshIndices(id), stride = model.meshStride(id);
    const place = (at) => words[indices[at] * stride] + ',' + words[indices[at] * stride + 1];
    for (let at = 0; at < indices.length; at += 3)
      for (let corner = 0; corner < 3; ++corner) {
        const a = place(at + corner), b = place(at + (corner + 1) % 3), key = a < b ? a + ' ' + b : b + ' ' + a;
        if (a !== b && !edges.delete(key)) edges.add(key);
      }
  }
  return edges.size;
}
"""


# Returns the PSNR of two pictures in dB. Ignores the borders, where the page shows text.
COMPARE = """
const texels = async (base64) => {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const image = await createImageBitmap(new Blob([bytes], {type: 'image/png'}));
  const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
  context.drawImage(image, 0, 0);
  return context.getImageData(200, 60, image.width - 400, image.height - 120).data;
};
return Promise.all([texels(arguments[0]), texels(arguments[1])]).then(([a, b]) => {
  let squares = 0;
  for (let i = 0; i < a.length; ++i) squares += (a[i] - b[i]) ** 2;
  return Math.min(99, 10 * Math.log10(255 ** 2 / (squares / (a.length * 3 / 4)))); // equal pictures: 99
});
"""


REFUSE_SHADERS = """
const {prototype} = WebGL2RenderingContext, get = prototype.getProgramParameter;
prototype.getProgramParameter = function(program, name) {
  return name !== this.LINK_STATUS && get.call(this, program, name);
};
"""


def link_to(server, model, camera, **more):
    """Returns the page's link to a view. @param camera  with eye, target, up and fov."""
    fields = {"model": model, **{name: ",".join(map(repr, camera[name])) for name in ("eye", "target", "up")},
              "fov": camera.get("fov", 45), **more}
    return f"http://{server.address}/#" + "&".join(f"{name}={value}" for name, value in fields.items())


def camera_file(folder, camera):
    path = pathlib.Path(folder, "camera.json")
    path.write_text(json.dumps({"fov_y_deg": camera.get("fov", 45),
                                "keys": [{name: camera[name] for name in ("eye", "target", "up")}]}))
    return path


def fetched(server, model, camera, folder):
    """Returns the summary of `lodestream fetch` after it has converged at the same view."""
    done = subprocess.run([BIN / "lodestream", "fetch", f"lode://{server.native}/{model}", "--camera",
                           camera_file(folder, camera), "--size", f"{WIDTH}x{HEIGHT}", "--cache", "off", "--json"],
                          capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


VIEWS = {"far": {"eye": [2.2, 1.2, 2.6], "target": [0, 0, 0], "up": [0, 1, 0]},
         "near": {"eye": [0.9, 0.5, 1.0], "target": [0.1, 0.1, 0], "up": [0, 1, 0], "fov": 30}}


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.server = cls.enterClassContext(Served(MODELS / "painted.lode"))
        cls.browser = cls.enterClassContext(Browser(WIDTH, HEIGHT))

    def show(self, view, **more):
        self.browser.open("about:blank")
        self.browser.open(link_to(self.server, "painted", VIEWS[view], **more))
        return self.browser.wait_for(CONVERGED) and self.browser.run("return window.lodestream.state()")

    def test_shows_the_cut_of_fetch(self):
        for view in VIEWS:
            with self.subTest(view):
                self.browser.run("return caches.keys().then(keys => Promise.all(keys.map(key => caches.delete(key))))") \
                    if self.browser.run("return 'caches' in window") else None
                expected, shown = fetched(self.server, "painted", VIEWS[view], self.folder), self.show(view, embed="")
                self.assertEqual(shown["triangles"], expected["triangles"])
                self.assertAlmostEqual(shown["error_px"], expected["max_error_px"], 5)
                self.assertLessEqual(shown["received_bytes"], 1.01 * expected["bytes_received"] + 1000)

    def test_has_no_open_edge_while_it_sharpens(self):
        # Show the whole model, because a cut may leave out parts that the camera does not see.
        self.browser.open("about:blank")
        self.browser.open(link_to(self.server, "painted", VIEWS["far"], px=16))
        self.browser.wait_for("Boolean(window.lodestream && window.lodestream.viewer().session)")
        self.browser.run(WATCH_EDGES)
        for threshold_px in (16, 8, 4, 2, 1, 0.5):
            self.browser.run(f"window.lodestream.viewer().settings.threshold_px = {threshold_px}")
            self.browser.wait_for(CONVERGED + f" && window.lodestream.state().error_px <= {threshold_px}")
        self.browser.drag(400, 300, 500, 250)
        self.browser.wait_for(CONVERGED)
        seen = self.browser.run("return window.seen.map(list => [list.parts.length, list.open])")
        self.assertGreater(len(seen), 4)
        self.assertEqual([open_edges for _, open_edges in seen], [0] * len(seen), seen)

    def test_loads_nothing_from_other_hosts_and_reports_no_error(self):
        self.show("far")
        self.browser.requested(), self.browser.console()
        self.browser.open(f"http://{self.server.address}/")
        self.browser.wait_for("document.querySelectorAll('#cards li').length === 1")
        self.show("far")
        for url in self.browser.requested():
            self.assertRegex(url, rf"^(https?|ws)://{self.server.address}/|^data:|^blob:|^about:")
        self.assertEqual([line for line in self.browser.console() if "GPU stall" not in line and "GL Driver" not in line], [])
        self.assertEqual(self.browser.run("return window.lodestream.state().errors"), [])
        self.assertEqual(self.browser.run("return document.cookie"), "")

    def test_turns_with_a_drag_and_keeps_the_camera_in_the_link(self):
        self.show("far")
        before = self.browser.run("return window.lodestream.viewer().camera.eye")
        self.browser.drag(480, 270, 600, 270)
        self.browser.wait_for(CONVERGED)
        after = self.browser.run("return window.lodestream.viewer().camera")
        self.assertGreater(math.dist(before, after["eye"]), 0.1)
        self.assertAlmostEqual(math.hypot(*before), math.hypot(*after["eye"]), delta=0.5)

    def test_keeps_its_canvas_for_the_next_model(self):
        self.show("far")
        self.browser.run("window.kept = window.lodestream.viewer().session.canvas")
        self.browser.run("location.hash = '#model=nothing'")
        self.browser.wait_for("window.lodestream.viewer()?.session?.stream.failure")
        self.assertEqual(self.browser.run("return getComputedStyle(window.kept).visibility"), "hidden")
        self.browser.run(f"location.hash = {link_to(self.server, 'painted', VIEWS['near']).partition('#')[2]!r}")
        self.browser.wait_for(CONVERGED)
        self.assertEqual(self.browser.run("const {canvas} = window.lodestream.viewer().session;"
                                          "return [canvas === window.kept, getComputedStyle(canvas).visibility]"), [True, "visible"])

    def test_shows_the_same_picture_after_its_context_is_lost(self):
        self.show("far", embed="")
        self.browser.picture(self.folder / "before.png")
        self.browser.run("window.lost = window.lodestream.viewer().session.canvas;"
                         "window.lost.getContext('webgl2').getExtension('WEBGL_lose_context').loseContext()")
        self.browser.wait_for(f"window.lodestream.viewer().session.canvas !== window.lost && {CONVERGED}")
        self.browser.picture(self.folder / "after.png")
        pictures = [base64.b64encode((self.folder / name).read_bytes()).decode() for name in ("before.png", "after.png")]
        self.assertGreater(self.browser.run(COMPARE, *pictures), 50)
        self.assertEqual(self.browser.run("return window.lodestream.state().errors"), [])

    def test_says_that_the_driver_refuses_a_shader(self):
        script = self.browser.tool("Page.addScriptToEvaluateOnNewDocument", source=REFUSE_SHADERS)
        self.addCleanup(self.browser.tool, "Page.removeScriptToEvaluateOnNewDocument", **script)
        self.browser.open("about:blank")
        self.browser.open(link_to(self.server, "painted", VIEWS["far"]))
        self.browser.wait_for("document.body.innerText.includes('WebGL cannot run a shader')")

    def test_says_what_is_wrong_with_a_model_that_is_not_there(self):
        self.browser.open("about:blank")
        self.browser.open(f"http://{self.server.address}/#model=nothing")
        text = self.browser.wait_for("document.body.innerText.includes('nothing') && document.body.innerText")
        self.assertNotIn("undefined", text)

    @unittest.skipIf(shutil.which("xvfb-run") is None, "there is no xvfb-run")
    def test_draws_the_picture_of_render(self):
        self.show("far", embed="", show="unlit")
        self.browser.picture(self.folder / "page.png")
        subprocess.run(["xvfb-run", "-a", BIN / "lodestream", "render", f"lode://{self.server.native}/painted", "--camera",
                        camera_file(self.folder, VIEWS["far"]), "--size", f"{WIDTH}x{HEIGHT}", "--unlit", "-o",
                        self.folder / "render.png"], check=True, capture_output=True)
        pictures = [base64.b64encode((self.folder / name).read_bytes()).decode() for name in ("page.png", "render.png")]
        self.browser.open("about:blank")
        self.assertGreater(self.browser.run(COMPARE, *pictures), 38)


if __name__ == "__main__":
    if browser.missing() or not (PAGE / "index.html").exists():
        print(f"skipped: there is no {browser.missing() or 'page in client/web/dist'}")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
