#!/usr/bin/env python3
"""Makes pictures of the page in Chromium: browser_pictures.py BIN_DIR MODELS_DIR

Writes browser.png, MODELS_DIR/armadillo.lode in the page, and browser_sharpening.png, five of the pictures that the page shows of
MODELS_DIR/asteroid.lode while it arrives over an emulated link, into this script's folder. The latter needs root and BIN_DIR/wan.
Needs Chromium with its driver, and Xvfb: Mesa draws. make.sh calls it.
"""
import base64
import contextlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
TESTS = HERE.parent.parent / "tests"
sys.path[:0] = [str(TESTS / "integration"), str(TESTS / "load"), str(TESTS / "bench")]
import browser  # noqa: E402
from bench_browser import inside  # noqa: E402
from processes import display, running  # noqa: E402
from surroundings import long_link  # noqa: E402

WITH_MESA = ["--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=gl", "--ignore-gpu-blocklist", "--hide-scrollbars"]
CONVERGED = "window.lodestream?.state().converged"
NOTES_S = 6  # notices disappear
PORT = 7480
DELAY_MS, MBIT_S = 25, 10
ARMADILLO = "eye=60,25,-215&target=0,0,0&up=0,1,0&fov=40"

# Keeps a copy of each picture that has a smaller error than the one before.
KEEP_PICTURES = """
const request = window.requestAnimationFrame.bind(window), kept = window.kept = [];
let start = null;
window.requestAnimationFrame = (call) => request((now) => {
  call(now);
  const viewer = lodestream.viewer(), canvas = document.querySelector('#stage canvas'), state = lodestream.state();
  if (!canvas || !state.parts || !viewer.answer.drawn || state.error_px >= (kept.at(-1)?.error_px ?? Infinity)) return;
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  copy.getContext('2d').drawImage(canvas, 0, 0);
  kept.push({copy, ms: performance.now() - window.start, error_px: state.error_px, bytes: state.received_bytes});
});
window.start = performance.now();
location.hash = arguments[0];
"""

# Puts the first, the last, and those between whose errors are spaced most evenly side by side.
MAKE_STRIP = """
const count = 5, [side, height] = arguments, last = kept.length - 1;
const ratio = (kept[last].error_px / kept[0].error_px) ** (1 / (count - 1));
const chosen = [0];
for (let i = 1; i < count; ++i) {
  const wanted = Math.log(kept[0].error_px * ratio ** i);
  const left = kept.map((_, at) => at).filter((at) => at > chosen.at(-1) && at <= last - (count - 1 - i));
  left.sort((a, b) => Math.abs(Math.log(kept[a].error_px) - wanted) - Math.abs(Math.log(kept[b].error_px) - wanted));
  chosen.push(i === count - 1 ? last : left[0]);
}
const strip = new OffscreenCanvas(count * side, height), context = strip.getContext('2d');
context.font = '13px sans-serif';
context.textAlign = 'center';
context.imageSmoothingQuality = 'high';
chosen.forEach((at, place) => {
  const {copy, ms, error_px, bytes} = kept[at];
  const from = Math.min(copy.width, copy.height * side / height);
  context.drawImage(copy, (copy.width - from) / 2, 0, from, copy.height, place * side, 0, side, height);
  context.fillStyle = '#fff';
  const text = `${error_px.toPrecision(2)} px · ${(ms / 1000).toFixed(1)} s · ${Math.round(bytes / 1000)} KB`;
  context.fillText(text, (place + 0.5) * side, height - 10);
});
return strip.convertToBlob().then(async (blob) => {
  const bytes = new Uint8Array(await blob.arrayBuffer());
  return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
});
"""


@contextlib.contextmanager
def served(bin_dir, store, host, prefix=()):
    """Yields the address of the page."""
    command = [*prefix, bin_dir / "lodestreamd", "serve", store, "--listen", f"{host}:{PORT + 1}", "--http", f"{host}:{PORT}", "--public",
               "--insecure"]
    with running(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        yield json.loads(server.stdout.readline())["http"]


def page(bin_dir, store):
    with served(bin_dir, store, "127.0.0.1") as address, browser.Browser(1280, 720) as window:
        window.open(f"http://{address}/#model={store.stem}&{ARMADILLO}")
        window.wait_for(CONVERGED)
        time.sleep(NOTES_S)
        window.picture(HERE / "browser.png")


def sharpening(bin_dir, store):
    with contextlib.ExitStack() as ending:
        near, far = ending.enter_context(long_link(bin_dir, DELAY_MS, MBIT_S))
        address = ending.enter_context(served(bin_dir, store, "10.9.0.1", near))
        ending.enter_context(inside(far[-1]))
        window = ending.enter_context(browser.Browser(480, 480))
        window.open(f"http://{address}/#model=-")  # there is none: the page and its core start
        window.wait_for("lodestream.viewer()?.session?.stream.failure")
        window.run(KEEP_PICTURES, f"#model={store.stem}")
        window.wait_for("lodestream.state().parts && " + CONVERGED)
        (HERE / "browser_sharpening.png").write_bytes(base64.b64decode(window.run(MAKE_STRIP, 240, 260)))


def main():
    bin_dir, models = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    browser.ARGUMENTS[:] = WITH_MESA
    with display() as screen:
        os.environ["DISPLAY"] = screen
        page(bin_dir, models / "armadillo.lode")
        sharpening(bin_dir, models / "asteroid.lode")


if __name__ == "__main__":
    main()
