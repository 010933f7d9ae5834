#!/usr/bin/env python3
"""Makes pictures of the page in Chromium: browser_pictures.py BIN_DIR MODELS_DIR

Writes browser.png, MODELS_DIR/armadillo.lode in the page, and browser_sharpening.png, five of the pictures that the page shows of
MODELS_DIR/asteroid.lode while it arrives over an emulated link, into this script's folder. The latter needs root and BIN_DIR/wan.
Needs Chromium with its driver, and Xvfb: Mesa draws. make.sh calls it.
"""
import base64
import collections
import contextlib
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time
import zlib

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
DELAY_MS, MBIT_S = 25, 1
ARMADILLO = "eye=-0.55,0.35,1.65&target=-0.01,-0.07,0&up=0,1,0&fov=34"

# Keeps a copy of each picture of which more had arrived than of the one before.
KEEP_PICTURES = """
const request = window.requestAnimationFrame.bind(window), kept = window.kept = [];
let start = null;
window.requestAnimationFrame = (call) => request((now) => {
  call(now);
  const viewer = lodestream.viewer(), canvas = document.querySelector('#stage canvas'), state = lodestream.state();
  if (!canvas || !state.parts || !viewer.answer.drawn || state.received_bytes <= (kept.at(-1)?.bytes ?? 0)) return;
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  copy.getContext('2d').drawImage(canvas, 0, 0);
  kept.push({copy, ms: performance.now() - window.start, error_px: state.error_px, bytes: state.received_bytes});
});
window.start = performance.now();
location.hash = arguments[0];
"""

# Returns bytes as text.
SEND = """
const send = (bytes) => {
  let text = '';
  for (let at = 0; at < bytes.length; at += 8192) text += String.fromCharCode(...bytes.subarray(at, at + 8192));
  return btoa(text);
};
"""

READ_PICTURE = SEND + """
return fetch('data:image/png;base64,' + arguments[0]).then((file) => file.blob()).then(createImageBitmap).then((image) => {
  const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
  context.drawImage(image, 0, 0);
  return send(context.getImageData(0, 0, image.width, image.height).data);
});
"""

# Puts the first, the last, and those between whose bytes grow most evenly side by side.
MAKE_STRIP = SEND + """
const count = 5, [side, height] = arguments, last = kept.length - 1;
const ratio = (kept[last].bytes / kept[0].bytes) ** (1 / (count - 1));
const chosen = [0];
for (let i = 1; i < count; ++i) {
  const wanted = Math.log(kept[0].bytes * ratio ** i), distance = (at) => Math.abs(Math.log(kept[at].bytes) - wanted);
  const left = [...kept.keys()].filter((at) => at > chosen.at(-1) && at <= last - (count - 1 - i));
  chosen.push(i === count - 1 ? last : left.reduce((best, at) => (distance(at) < distance(best) ? at : best)));
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
  const text = `${error_px < 10 ? error_px.toPrecision(2) : Math.round(error_px)} px · ${(ms / 1000).toFixed(1)} s · ${Math.round(bytes / 1000)} KB`;
  context.fillText(text, (place + 0.5) * side, height - 10);
});
return send(context.getImageData(0, 0, strip.width, strip.height).data);
"""


def palette_of(counts):
    """Returns a palette of 256 colours by median cut, and the place of each colour in it. @param counts  of each colour"""
    boxes = [list(counts)]
    spread = lambda box: max(max(values) - min(values) for values in zip(*box)) * math.sqrt(sum(counts[colour] for colour in box))
    spreads = [spread(boxes[0])]
    while len(boxes) < 256 and max(spreads) > 0:
        at = spreads.index(max(spreads))
        box = boxes.pop(at)
        spreads.pop(at)
        ranges = [max(values) - min(values) for values in zip(*box)]
        box.sort(key=lambda colour: colour[ranges.index(max(ranges))])
        for half in (box[:len(box) // 2], box[len(box) // 2:]):
            boxes.append(half)
            spreads.append(spread(half))
    mean = lambda box, channel: round(sum(colour[channel] * counts[colour] for colour in box) / sum(counts[colour] for colour in box))
    return [tuple(mean(box, channel) for channel in range(3)) for box in boxes], {
        colour: place for place, box in enumerate(boxes) for colour in box}


def write_png(file, width, texels):
    """Writes texels, given as text of RGBA, with a palette, which makes the file half as large."""
    rgba = base64.b64decode(texels)
    colours = list(zip(rgba[0::4], rgba[1::4], rgba[2::4]))
    palette, place_of = palette_of(collections.Counter(colours))
    places = bytes(place_of[colour] for colour in colours)
    rows = b"".join(b"\0" + places[at:at + width] for at in range(0, len(places), width))
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", width, len(places) // width, 8, 3, 0, 0, 0)),
              (b"PLTE", bytes(value for colour in palette for value in colour)), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks))


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
        with tempfile.NamedTemporaryFile(suffix=".png") as file:
            window.picture(file.name)
            shown = base64.b64encode(file.read()).decode()
        window.open("about:blank")  # the page allows no addresses of data
        write_png(HERE / "browser.png", 1280, window.run(READ_PICTURE, shown))


def sharpening(bin_dir, store):
    with contextlib.ExitStack() as ending:
        near, far = ending.enter_context(long_link(bin_dir, DELAY_MS, MBIT_S))
        address = ending.enter_context(served(bin_dir, store, "10.9.0.1", near))
        ending.enter_context(inside(far[-1]))
        window = ending.enter_context(browser.Browser(720, 720))
        window.open(f"http://{address}/#model=-")  # there is none: the page and its core start
        window.wait_for("lodestream.viewer()?.session?.stream.failure")
        window.run(KEEP_PICTURES, f"#model={store.stem}")
        window.wait_for("lodestream.state().parts && " + CONVERGED)
        write_png(HERE / "browser_sharpening.png", 5 * 240, window.run(MAKE_STRIP, 240, 260))


def main():
    bin_dir, models = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    browser.ARGUMENTS[:] = WITH_MESA
    with display() as screen:
        os.environ["DISPLAY"] = screen
        page(bin_dir, models / "armadillo.lode")
        sharpening(bin_dir, models / "asteroid.lode")


if __name__ == "__main__":
    main()
