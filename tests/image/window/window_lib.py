# SPDX-License-Identifier: Apache-2.0
"""A virtual screen, a window of `tessera-master view` on it, and a hand that moves mouse and keys.

Needs Xvfb and xdotool. Times are seconds of the monotonic clock, which the program's log uses, too.
"""
import contextlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import time

PATIENCE_S = 180


def program(name):
    return str(pathlib.Path(os.environ["TESSERA_BIN"], name))


def missing_tool():
    return next((tool for tool in ("Xvfb", "xdotool", "idiff") if shutil.which(tool) is None), None)


def wait_until(what, condition, seconds=PATIENCE_S):
    """Polls until `condition` returns something true, and returns that."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        answer = condition()
        if answer:
            return answer
        time.sleep(0.01)
    raise AssertionError(f"after {seconds} s: still not {what}")


class Screen:
    def __enter__(self):
        reader, writer = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(writer), "-screen", "0", "1280x800x24", "-noreset"],
                                       pass_fds=[writer], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)
        os.close(writer)
        with os.fdopen(reader) as number:
            self.display = ":" + number.readline().strip()
        assert self.display != ":", "Xvfb did not start"
        self.environment = {**os.environ, "DISPLAY": self.display, "LIBGL_ALWAYS_SOFTWARE": "1"}
        self.environment.pop("WAYLAND_DISPLAY", None)
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()


class Window:
    """A running `view`. Its log lines are read as they come; `events` holds those of the window."""

    def __init__(self, screen, folder, scene, *options):
        self.screen, self.folder = screen, pathlib.Path(folder)
        self.stats_path = self.folder / "stats.jsonl"
        self.lines, self.events = [], []  # lines are (when it was read, text), events dictionaries
        self.process = subprocess.Popen(
            [program("tessera-master"), "view", scene, "--log-level", "debug", "--log-format", "json", "--stats",
             str(self.stats_path), *options], cwd=self.folder, env=screen.environment, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1)
        self.printed = []
        self.readers = [threading.Thread(target=self.read, args=(self.process.stderr, self.lines)),
                        threading.Thread(target=self.read, args=(self.process.stdout, self.printed))]
        for reader in self.readers:
            reader.start()

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if self.process.poll() is None:
            self.process.terminate()
        code = self.process.wait(60)
        for reader in self.readers:
            reader.join()
        self.process.stdout.close()
        self.process.stderr.close()
        if kind is None:
            assert code == 0, f"view ended with {code}: {self.lines[-1:]}"
        else:
            print("".join(text for _, text in self.lines[-30:]), file=sys.stderr)

    def read(self, stream, into):
        for text in stream:
            into.append((time.monotonic(), text))
            if text.startswith("{") and '"at"' in text:
                event = json.loads(text)
                self.events.append({key: float(value) if re.fullmatch(r"[\d.]+", value) else value
                                    for key, value in event.items()})

    # What the program has said:
    def line_time(self, words):
        return wait_until(f"a line with '{words}'", lambda: self.find_line(words))[0]

    def find_line(self, words, after=0):
        return next(((at, text) for at, text in self.lines if words in text and at >= after), None)

    def shown(self, after=0):
        return [e for e in self.events if e["event"] == "frame-shown" and e["at"] >= after]

    def changes(self, after=0):
        return [e for e in self.events if e["event"] == "view-changed" and e["at"] >= after]

    def stats(self):
        if not self.stats_path.exists():
            return []
        return [json.loads(line) for line in self.stats_path.read_text().splitlines() if line.endswith("}")]

    def wait_for_full(self, after=0, passes=1, width=None):
        """Waits for a frame to be shown that has everything, and so many passes. Returns: the first such."""
        def there():
            return next((e for e in self.shown(after)
                         if e["passes"] >= passes and width in (None, e["width"])), None)
        return wait_until(f"a full frame of {passes} passes", lambda: there() or self.ended())

    def wait_at_rest(self):
        """Waits until everything of the newest view is shown."""
        def there():
            changes, shown = self.changes(), self.shown()
            return shown and shown[-1]["passes"] >= 1 and (not changes or shown[-1]["revision"] >= changes[-1]["revision"])
        wait_until("a full frame of the newest view", lambda: there() or self.ended())

    def ended(self):
        assert self.process.poll() is None, f"view ended: {self.lines[-3:]}"

    # What the hand does:
    def hand(self, *words):
        subprocess.run(["xdotool", *map(str, words)], env=self.screen.environment, check=True,
                       stdout=subprocess.PIPE, timeout=PATIENCE_S)

    def find(self):
        """Waits for the window; keys go to it from here on."""
        def search():
            found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "^Tessera: "], env=self.screen.environment,
                                   stdout=subprocess.PIPE, text=True, check=False).stdout.split()
            return found[0] if found else self.ended()
        self.id = wait_until("a window", search)
        self.hand("windowfocus", self.id)
        return self

    def press(self, key):
        self.hand("windowfocus", self.id, "key", key)

    def mouse_to(self, x, y):
        self.hand("mousemove", "--window", self.id, x, y)

    @contextlib.contextmanager
    def moving_hand(self):
        """Gives a function like mouse_to that starts no program each time, which would slow down what it measures."""
        with subprocess.Popen(["xdotool", "-"], env=self.screen.environment, stdin=subprocess.PIPE, text=True,
                              bufsize=1) as hand:
            yield lambda x, y: hand.stdin.write(f"mousemove --window {self.id} {x} {y}\n")
            hand.stdin.close()
            assert hand.wait(PATIENCE_S) == 0

    def resize(self, width, height):
        self.hand("windowsize", self.id, width, height)
