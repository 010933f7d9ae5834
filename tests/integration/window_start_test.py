#!/usr/bin/python3
"""Tests of the window that starts without a target; see driven_window.py."""
import contextlib
import pathlib
import stat
import subprocess
import tempfile

from driven_window import BIN, HEIGHT, STORE, WIDTH, Window, WindowTest, main
from processes import display, eventually


def title(window):
    return window.xdotool("getwindowname", window.id).strip()


def reds_in(rows):
    """Counts the pixels that have the colour of errors."""
    pixels = b"".join(rows)
    return sum(r > 200 and g < 150 and b < 140 for r, g, b in zip(pixels[::3], pixels[1::3], pixels[2::3]))


class StartPage(WindowTest):
    @contextlib.contextmanager
    def page(self, **pipes):
        with self.window(None, is_open=False, **pipes) as window:
            self.assertEqual(title(window), "Lodestream")
            eventually(lambda: max(map(max, window.pixels())) > 200)  # the page is drawn, and has the keyboard
            yield window

    @staticmethod
    def type(window, path):
        window.xdotool("type", "--delay", "0", str(path))
        window.key("Return")

    def test_opens_a_typed_path(self):
        with self.page() as window:
            self.type(window, STORE)
            eventually(lambda: title(window) == "painted - Lodestream")
            window.picture()  # the key also closes the help of the first start
            self.assertEqual(window.leave(), 0)

    def test_opens_a_dropped_file(self):
        with self.page() as window:
            window.drop(STORE)
            eventually(lambda: title(window) == "painted - Lodestream")

    def test_types_letters_that_are_keys_elsewhere(self):
        with tempfile.TemporaryDirectory() as folder, self.page() as window:
            file = pathlib.Path(folder, "qwerty-jkxp.lode")
            file.symlink_to(STORE)
            self.type(window, file)
            eventually(lambda: title(window) == "qwerty-jkxp - Lodestream")

    def test_tells_why_a_file_cannot_be_opened_and_stays(self):
        with tempfile.TemporaryDirectory() as folder, self.page(stderr=subprocess.DEVNULL) as window:
            broken = pathlib.Path(folder, "broken.ply")
            broken.write_text("ply\nnonsense\n")
            before = reds_in(window.pixels())
            self.type(window, "/no/such/file.ply")
            eventually(lambda: reds_in(window.pixels()) > before + 100)
            window.drop(broken)
            eventually(lambda: title(window) == "Lodestream" and reds_in(window.pixels()) > before + 100)
            window.drop(STORE)
            eventually(lambda: title(window) == "painted - Lodestream")

    def test_lists_files_that_were_opened_before_and_opens_them(self):
        with tempfile.TemporaryDirectory() as folder, display(folder) as screen:
            kept, gone = (pathlib.Path(folder, f"{name}.lode") for name in ("kept", "gone"))
            for target in (kept, gone):
                target.write_bytes(STORE.read_bytes())
                with Window(screen, folder, None) as window:
                    window.drop(target)
                    eventually(lambda target=target: title(window) == f"{target.stem} - Lodestream")
            gone.unlink()
            recent = pathlib.Path(folder, "lodestream", "recent.json")
            self.assertEqual(stat.S_IMODE(recent.stat().st_mode), 0o600)
            with Window(screen, folder, None) as window:
                for y in range(HEIGHT // 2 - 40, HEIGHT - 20, 6):
                    window.click((WIDTH // 4, y))
                    if title(window) != "Lodestream":
                        break
                eventually(lambda: title(window) == "kept - Lodestream")

    def test_does_not_open_a_missing_file(self):
        with tempfile.TemporaryDirectory() as folder, display(folder) as screen:
            gone = pathlib.Path(folder, "gone.lode")
            gone.write_bytes(STORE.read_bytes())
            with Window(screen, folder, gone) as window:
                eventually(lambda: title(window) == "gone - Lodestream")
            gone.unlink()
            with Window(screen, folder, None) as window:
                for y in range(HEIGHT // 2 - 40, HEIGHT - 20, 6):
                    window.click((WIDTH // 4, y))
                self.assertEqual(title(window), "Lodestream")
                self.assertEqual(window.leave(), 0)

    def test_opens_for_the_program_without_words(self):
        with tempfile.TemporaryDirectory() as folder, display(folder) as screen:
            window = Window(screen, folder, None)
            window.command = [BIN / "lodestream"]
            with window:
                self.assertEqual(title(window), "Lodestream")
                self.assertEqual(window.leave(), 0)

    def test_needs_a_display(self):
        for words, said in (([], "A subcommand is required"), (["view"], "target is required")):
            done = subprocess.run([BIN / "lodestream", *words], env={}, capture_output=True, text=True)
            self.assertEqual(done.returncode, 2)
            self.assertIn(said, done.stderr)


if __name__ == "__main__":
    main()
