#!/usr/bin/env python3
"""Pictures of the window with its panel, driven by keys and a pointer: window_pictures.py BIN_DIR MODELS_DIR

Of MODELS_DIR/terrain.lode, into this script's folder. Needs Xvfb and xdotool; make.sh calls it.
"""
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent.parent / "tests" / "integration"))
import driven_window  # noqa: E402

MODEL = driven_window.MODELS / "terrain.lode"
driven_window.WIDTH, driven_window.HEIGHT = 960, 540


def save(name, window):
    (HERE / f"{name}.png").write_bytes(window.picture())


def picks(window):
    for place in ((330, 330), (620, 270)):
        window.click(place)
    window.move((700, 350))


def walk(window):
    window.move((560, 330))
    for _ in range(2):
        window.key("Tab")
    window.picture()


def errors(window):
    for _ in range(3):
        window.key("v")
    window.move((560, 330))


def main():
    with driven_window.display() as screen:
        for name, act in (("window", picks), ("window_walk", walk), ("window_errors", errors)):
            with tempfile.TemporaryDirectory() as folder, driven_window.Window(screen, folder, MODEL, "--pixels", "1") as window:
                window.picture()
                window.key("F1")
                act(window)
                save(name, window)


if __name__ == "__main__":
    main()
