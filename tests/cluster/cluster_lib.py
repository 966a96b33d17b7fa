# SPDX-License-Identifier: Apache-2.0
"""Real processes for the cluster tests: a master, slaves, applications, with keys, on free loopback ports.

TESSERA_BIN names the folder of the programs. Every process that a Cluster starts is ended by it.
"""
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

SKIP = 77
# Ends what would hang for ever. Nothing is judged by it, since sanitizer builds on a busy machine are slow.
PATIENCE_S = 300
# A master that gives nobody up who stands still for 25 s: for tests that count who is lost, and ask something else. With
# the usual 1.25 s a busy machine loses a slave now and then, which comes back.
CALM = ("--heartbeats-missed", "99")
LATE = ("no answer in time", "silent for too long")  # an application says so of a master that is there and slow


def program(name):
    folder = os.environ.get("TESSERA_BIN")
    if not folder:
        sys.exit("TESSERA_BIN is not set: the folder of tessera-master and the others")
    return str(pathlib.Path(folder, name))


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIP)


def is_quiet():
    """Returns whether others have left the processors alone in the last minute, as far as the load tells. Otherwise the
    tests in the lab print their figures and judge nothing that rests on time."""
    load = os.getloadavg()[0]
    quiet = load < os.cpu_count() + 1
    if not quiet:
        print(f"a load of {load:.1f} on {os.cpu_count()} processors: not judged")
    return quiet


def part_of(items, part):
    """Returns every N-th item from the I-th on, for the part "I/N", where I counts from 1."""
    number, count = map(int, part.split("/"))
    return items[number - 1::count]


def main(verbosity=2):
    """Runs the tests of the file that was started, or a part of them with the first words --part I/N, so that parts run
    at once."""
    class Loader(unittest.TestLoader):
        part = "1/1"

        def getTestCaseNames(self, case):
            return part_of(super().getTestCaseNames(case), self.part)
    loader = Loader()
    if sys.argv[1:2] == ["--part"]:
        loader.part = sys.argv[2]
        del sys.argv[1:3]
    unittest.main("__main__", verbosity=verbosity, testLoader=loader)


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def wait_until(what, condition, seconds=PATIENCE_S, pause_max=0.25):
    """Polls until `condition` returns something true, and returns that.

    A question may cost as much as what is waited for (a status is a process with a handshake). So between two questions
    twice the time passes that one took, within [0.02, pause_max] seconds."""
    end = time.monotonic() + seconds
    while True:
        asked = time.monotonic()
        answer = condition()
        if answer:
            return answer
        now = time.monotonic()
        if now > end:
            raise AssertionError(f"after {seconds} s: still not {what}")
        time.sleep(min(max(2 * (now - asked), 0.02), pause_max))


class Run:
    """How one program ended: exit code, output, and the lines of its statistics."""

    def __init__(self, code, stdout, stderr, stats):
        self.code, self.stdout, self.stderr, self.stats = code, stdout, stderr, stats

    @property
    def digests(self):
        return [line["digest"] for line in self.stats]


class Cluster:
    """One key folder, at most one serving master, slaves and applications.

    host is where the master listens; prefix(node) gives the words that go before a command so that
    it runs on that node of a lab: node 1 is that of master and applications, slaves are given theirs.
    """

    def __init__(self, host="127.0.0.1", prefix=lambda node: []):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tessera-cluster-"))
        self.keys = self.folder / "keys"
        self.host, self.prefix = host, prefix
        self.port = None
        self.processes = {}
        self.runs = 0

    def __enter__(self):
        self.make_keys("init", str(self.keys))
        self.add_key("master", "master")
        self.add_key("app", "app")
        return self

    def __exit__(self, kind, value, traceback):
        for process in self.processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.terminate()
        unclean = []
        for name, process in self.processes.items():
            try:
                code = process.wait(PATIENCE_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                code = "none: it did not end when asked"
            if code not in (0, -signal.SIGKILL, -signal.SIGTERM):
                unclean.append(f"{name}: exit code {code}")
        if kind is not None or unclean:
            for log in sorted(self.folder.glob("*.log")):
                print(f"--- {log.name}\n" + "".join(log.read_text(errors="replace").splitlines(True)[-20:]))
        shutil.rmtree(self.folder, ignore_errors=True)
        if kind is None and unclean:
            raise AssertionError("daemons that ended badly: " + ", ".join(unclean))

    def make_keys(self, *words):
        subprocess.run([program("tessera-keys"), *words], check=True, stdout=subprocess.DEVNULL)

    def add_key(self, role, name):
        if not (self.keys / name).exists():
            self.make_keys("add", str(self.keys), role, name)
        return str(self.keys / name)

    @property
    def address(self):
        return f"{self.host}:{self.port}"

    def start(self, name, words, node=1):
        """Starts a daemon in the background, whose output goes to NAME.log."""
        log = open(self.folder / f"{name}.log", "ab")
        process = subprocess.Popen([*self.prefix(node), *words], stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        log.close()
        self.processes[name] = process
        return process

    def serve(self, *options, keys=None):
        # Between free_port() and listen() another process may take the port, so several are tried.
        for _ in range(5):
            self.port = free_port()
            process = self.start("master", [program("tessera-master"), "serve", "--listen", self.address,
                                            "--keys", str(keys or self.keys / "master"), *options])
            if wait_until("listening", lambda: self.status() is not None or process.poll() is not None) and process.poll() is None:
                return process
        raise AssertionError("the master does not start: " + (self.folder / "master.log").read_text())

    def slave(self, name, *options, threads=1, node=2):
        return self.start(name, [program("tessera-slave"), "--master", self.address, "--keys",
                                 self.add_key("slave", name), "--name", name, "--threads", str(threads), *options], node)

    def slaves(self, count, *options, threads=1):
        for i in range(count):
            self.slave(f"slave-{i + 1}", *options, threads=threads)
        self.wait_for_slaves(count)

    def wait_for_slaves(self, count):
        wait_until(f"{count} slaves there", lambda: len((self.status() or {"slaves": []})["slaves"]) == count)

    def status(self):
        """Returns what the master says, None when there is none. One that has no time to answer is asked again."""
        def ask():
            run = subprocess.run([*self.prefix(1), program("tessera-master"), "status", "--json", "--connect", self.address, "--keys",
                                  str(self.keys / "app")], capture_output=True, text=True, timeout=PATIENCE_S)
            return None if any(word in run.stderr for word in LATE) else run
        run = wait_until("an answer in time", ask)
        return json.loads(run.stdout) if run.returncode == 0 else None

    def slave_status(self, name):
        status = self.status()
        return next((s for s in status["slaves"] if s["name"] == name), None) if status else None

    def end(self, name):
        process = self.processes.pop(name)
        process.terminate()
        assert process.wait(PATIENCE_S) in (0, -signal.SIGTERM), f"{name} ended with {process.returncode}"

    def wait_for_refusal(self, name):
        """Waits until the slave says that it is refused, looks that it lives on, and ends it. Returns that line."""
        log = self.folder / f"{name}.log"

        def told():
            return [line for line in log.read_text(errors="replace").splitlines() if "master-refuses" in line]
        line = wait_until(f"{name} is refused", told)[0]
        assert self.processes[name].poll() is None, f"{name} ended with {self.processes[name].returncode}"
        self.end(name)
        return line

    def start_render(self, scene, *options, connect=True, output=None):
        """Starts an application in the background; finish() waits for it. Without --renderer it is `direct`.

        Light and exposure are given, so that the frames counted here are those that were asked for: none
        comes before them to settle either."""
        self.runs += 1
        stats = self.folder / f"stats-{self.runs}.jsonl"
        words = [program("tessera-master"), "render", scene, "--quiet", "--stats", str(stats), *options]
        if "--renderer" not in options:
            words += ["--renderer", "direct"]
        if "--aa" not in options and "--passes" not in options:
            words += ["--aa", "1"]
        if "--light" not in options:
            words += ["--light", "scene" if scene.startswith("builtin:") else "studio", "--exposure", "0"]
        words += ["-o", output or str(self.folder / f"out-{self.runs}-%04d.pfm")]
        if connect:
            words += ["--connect", self.address, "--keys", str(self.keys / "app")]
        process = subprocess.Popen([*self.prefix(1), *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.processes[f"render-{self.runs}"] = process
        process.tessera = (f"render-{self.runs}", stats)
        return process

    def finish(self, process, seconds=PATIENCE_S):
        name, stats = process.tessera
        stdout, stderr = process.communicate(timeout=seconds)
        self.processes.pop(name, None)
        # An application that was stopped may have been writing its last line.
        text = stats.read_text() if stats.exists() else ""
        lines = [json.loads(line) for line in text[:text.rfind("\n") + 1].splitlines()]
        return Run(process.returncode, stdout, stderr, lines)

    def start_endless(self, scene, *options):
        """Renders frames until stop_render(), so that what is to happen between them does, however late."""
        return self.start_render(scene, *options, "--frames", "0:9999")

    def wait_for_frames(self, count, process):
        """Waits until so many frames are done from now on."""
        def done():
            assert process.poll() is None, f"it has ended: {process.communicate()[1]}"
            return (self.status() or {}).get("frames_done", 0)
        first = done()
        wait_until(f"{count} frames more", lambda: done() >= first + count)

    def stop_render(self, process):
        """Stops an application. Returns: a Run of the frames that it has drawn."""
        assert process.poll() is None, f"it has ended: {process.communicate()[1]}"
        process.terminate()
        return self.finish(process)

    def render(self, scene, *options, connect=True):
        """Renders and expects success. Returns: a Run."""
        run = self.finish(self.start_render(scene, *options, connect=connect))
        assert run.code == 0, f"render {scene} {' '.join(options)}: exit code {run.code}: {run.stderr}"
        return run
