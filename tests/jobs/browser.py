# SPDX-License-Identifier: Apache-2.0
"""Chromium without a display, asked through its own pipe: what a page says, shows, prints and answers."""
import base64
import json
import os
import shutil
import subprocess
import tempfile
import time

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
# Software drawing, no network, no helpers that ask for one.
SWITCHES = ("--headless=new", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
            "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking", "--disable-component-update",
            "--disable-sync", "--hide-scrollbars", "--remote-debugging-pipe")


def program():
    return next((found for name in PROGRAMS if (found := shutil.which(name))), None)


class Browser:
    """One page. `complaints` gathers exceptions, console errors and warnings, and requests that left the page."""

    def __init__(self, *switches):
        self.folder = tempfile.mkdtemp(prefix="scanmill-browser-")
        to_browser, self.out = os.pipe()
        self.inn, from_browser = os.pipe()
        # The browser reads file descriptor 3 and writes 4.
        script = f"exec 3<&{to_browser} 4>&{from_browser}; exec \"$@\""
        self.process = subprocess.Popen(
            ["/bin/bash", "-c", script, "sh", program(), *SWITCHES, *switches, f"--user-data-dir={self.folder}", "about:blank"],
            pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(to_browser)
        os.close(from_browser)
        self.rest, self.number, self.session, self.events, self.complaints = b"", 0, None, [], []
        pages = [t for t in self.ask("Target.getTargets")["targetInfos"] if t["type"] == "page"]
        self.session = self.ask("Target.attachToTarget", targetId=pages[0]["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self.out)
        os.close(self.inn)
        shutil.rmtree(self.folder, ignore_errors=True)

    def message(self):
        while b"\0" not in self.rest:
            part = os.read(self.inn, 1 << 20)
            assert part, "the browser is gone"
            self.rest += part
        text, self.rest = self.rest.split(b"\0", 1)
        told = json.loads(text)
        self.listen(told)
        return told

    def listen(self, told):
        name, what = told.get("method"), told.get("params", {})
        if name:
            self.events.append(name)
        if name == "Runtime.exceptionThrown":
            self.complaints.append(json.dumps(what["exceptionDetails"])[:600])
        elif name == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
            self.complaints.append(json.dumps(what["args"])[:600])
        elif name == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
            # A performance hint of the software renderer to whoever reads pixels back, as taking a screenshot does.
            if "GPU stall due to ReadPixels" not in what["entry"]["text"]:
                self.complaints.append(what["entry"]["text"])
        elif name == "Network.requestWillBeSent" and not what["request"]["url"].startswith(("file:", "data:", "about:")):
            self.complaints.append("asks the network for " + what["request"]["url"])

    def ask(self, method, **params):
        self.number += 1
        request = {"id": self.number, "method": method, "params": params}
        if self.session:
            request["sessionId"] = self.session
        os.write(self.out, json.dumps(request).encode() + b"\0")
        while True:
            told = self.message()
            if told.get("id") == self.number:
                assert "error" not in told, f"{method}: {told['error']}"
                return told["result"]

    def size(self, width, height, mobile=False, dots=1):
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=dots, mobile=mobile)
        self.ask("Emulation.setTouchEmulationEnabled", enabled=mobile, maxTouchPoints=5)

    def open(self, path, address=""):
        # A page of its own each time: an address that differs behind '#' only would stay on the one that is open.
        for url in ("about:blank", f"file://{os.path.abspath(path)}{address}"):
            self.events.clear()
            self.ask("Page.navigate", url=url)
            while "Page.loadEventFired" not in self.events:
                self.message()

    def value(self, expression):
        told = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in told, told
        return told["result"].get("value")

    def until(self, expression, seconds=30):
        end = time.monotonic() + seconds
        while not self.value(f"!!({expression})"):
            assert time.monotonic() < end, f"never true: {expression}"
            time.sleep(0.05)

    def settle(self):
        """Until what was asked for is drawn."""
        self.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def picture(self, clip=None, whole=False):
        self.settle()
        more = {"clip": {**clip, "scale": 1}} if clip else {}
        return base64.b64decode(self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=whole, **more)["data"])

    def paper(self):
        return base64.b64decode(self.ask("Page.printToPDF", printBackground=False, preferCSSPageSize=True)["data"])

    def mouse(self, kind, x, y, **more):
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, start, end, **more):
        button = more.pop("button", "left")
        buttons = {"left": 1, "right": 2, "middle": 4}[button]
        self.mouse("mousePressed", *start, button=button, buttons=buttons, clickCount=1, **more)
        for step in (1, 2, 3):
            at = [a + (b - a) * step / 3 for a, b in zip(start, end)]
            self.mouse("mouseMoved", *at, button=button, buttons=buttons, **more)
        self.mouse("mouseReleased", *end, button=button, clickCount=1, **more)

    def key(self, name, code=None, **more):
        text = {"text": name} if len(name) == 1 else {}
        self.ask("Input.dispatchKeyEvent", type="keyDown", key=name, code=code or name, **text, **more)
        self.ask("Input.dispatchKeyEvent", type="keyUp", key=name, code=code or name, **more)

    def touch(self, *steps):
        """Steps of finger places; every list as long as the first."""
        for number, places in enumerate(steps):
            points = [{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(places)]
            self.ask("Input.dispatchTouchEvent", type="touchMove" if number else "touchStart", touchPoints=points)
        self.ask("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
