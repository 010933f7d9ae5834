"""Drives Debian's Chromium through chromedriver, by the WebDriver protocol (https://www.w3.org/TR/webdriver2/)."""
import base64
import contextlib
import json
import pathlib
import shutil
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

# Software rendering makes pictures similar on all machines.
ARGUMENTS = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--hide-scrollbars"]


def missing():
    """Returns the name of a missing program, or None."""
    return next((name for name in ("chromium", "chromedriver") if shutil.which(name) is None), None)


class Browser:
    """A browser with one window. Use as `with Browser(1280, 720) as browser`."""

    def __init__(self, width, height, touch=False):
        self.size, self.touch = (width, height), touch

    def __enter__(self):
        self.stack = contextlib.ExitStack()
        profile = self.stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True))
        log = self.stack.enter_context(tempfile.TemporaryFile("w+"))
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=log, text=True)
        self.stack.callback(self.end)
        for line in self.driver.stdout:
            if "successfully on port " in line:
                self.url = "http://127.0.0.1:" + line.rsplit(" ", 1)[1].strip().rstrip(".")
                break
        options = {"args": ARGUMENTS + [f"--user-data-dir={profile}"], "binary": shutil.which("chromium")}
        session = self.call("POST", "/session", {"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}}})
        self.session = f"/session/{session['sessionId']}"
        self.resize(*self.size)
        return self

    def __exit__(self, *_):
        self.stack.close()

    def end(self):
        with contextlib.suppress(Exception):
            self.call("DELETE", self.session)
        self.driver.terminate()
        self.driver.wait()
        self.driver.stdout.close()

    def call(self, method, path, body=None):
        data = json.dumps(body or {}).encode() if method == "POST" else None
        request = urllib.request.Request(self.url + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=300) as response:
                return json.load(response)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None

    def tool(self, command, **parameters):
        """Sends a command of Chromium's developer tools."""
        return self.call("POST", f"{self.session}/goog/cdp/execute", {"cmd": command, "params": parameters})

    def resize(self, width, height):
        self.tool("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=self.touch)
        if self.touch:
            self.tool("Emulation.setTouchEmulationEnabled", enabled=True)

    def open(self, url):
        self.call("POST", f"{self.session}/url", {"url": url})

    def run(self, script, *arguments):
        """Runs the body of a function and returns its result."""
        return self.call("POST", f"{self.session}/execute/sync", {"script": script, "args": list(arguments)})

    def wait_for(self, script, patience_s=120):
        """Waits until an expression is truthy, and returns its value."""
        end = time.monotonic() + patience_s
        while not (value := self.run("return " + script)):
            if time.monotonic() > end:
                raise AssertionError(f"{script} is still {value!r}; the console says {self.console()}")
            time.sleep(0.05)
        return value

    def picture(self, file):
        """Writes a PNG of the window's contents."""
        pathlib.Path(file).write_bytes(base64.b64decode(self.call("GET", f"{self.session}/screenshot")))

    def console(self):
        """Returns the console's messages since the last call."""
        return [entry["message"] for entry in self.call("POST", f"{self.session}/se/log", {"type": "browser"})]

    def requested(self):
        """Returns the addresses that pages and workers have requested since the last call."""
        events = [json.loads(entry["message"])["message"]
                  for entry in self.call("POST", f"{self.session}/se/log", {"type": "performance"})]
        return [event["params"]["request"]["url"] for event in events if event["method"] == "Network.requestWillBeSent"]

    def key(self, key):
        self.tool("Input.dispatchKeyEvent", type="keyDown", key=key, text=key if len(key) == 1 else "")
        self.tool("Input.dispatchKeyEvent", type="keyUp", key=key)

    def drag(self, x, y, to_x, to_y, steps=8):
        self.tool("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", clickCount=1)
        for step in range(1, steps + 1):
            self.tool("Input.dispatchMouseEvent", type="mouseMoved", x=x + (to_x - x) * step / steps,
                      y=y + (to_y - y) * step / steps, button="left", buttons=1)
        self.tool("Input.dispatchMouseEvent", type="mouseReleased", x=to_x, y=to_y, button="left", clickCount=1)

    def click(self, x, y):
        self.drag(x, y, x, y, steps=0)
