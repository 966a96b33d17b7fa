# SPDX-License-Identifier: Apache-2.0
"""One cluster in the lab for one row: master and application on node 1, slaves on the other nodes.

The lab is shared by all rows of a run; master, slaves and keys are each row's own. What a row measures is counted from
here, so that all rows count alike.
"""
import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "cluster"), str(HERE.parent / "faultlab")]
import cluster_lib  # noqa: E402
import faultlab  # noqa: E402
import bounds  # noqa: E402
import watch  # noqa: E402

NODES = 5
# A frame has eight tiles and more for each thread, so that a lost slave's tiles can be shared out.
FRAME = ["--size", "128x96", "--tile", "16"]
TILES = 48
SLEEP_MS = 40
MOVING_VERSION_MIB = 4.8  # what the master holds of one version of MOVING (F21 measures it)
# What a fault may cost the master, above the greatest before it, in MiB:
MEMORY_SLACK_MIB = sum((
    2 * 1.0,  # the send queues of its two links (kSendQueueLowBytes)
    4 * 0.2,  # buffers of its links and of its successor's: 64 KiB each for input and TLS, and OpenSSL's own
    4 * 0.15,  # frames of an application (kOutstandingMax) of 128 x 96 x 12 bytes
    3.0,  # what the allocator keeps of freed blocks: twice the largest (1 MiB), and a pad for each thread
))  # 6.4; and with MOVING the two versions that a slave which is silent or slow may hold up (F21)
METRICS = "127.0.0.1:9464"  # on the loopback of the master's node
STILL = ["builtin:cornell", "--orbit", "180"]  # one scene, each frame another picture
MOVING = ["builtin:waves"]                     # each frame another scene version

READ_PAGE = "import sys, urllib.request; print(urllib.request.urlopen(sys.argv[1], timeout=10).read().decode())"
PATIENCE_S = cluster_lib.PATIENCE_S


def wait_until(what, condition, seconds=PATIENCE_S):
    return cluster_lib.wait_until(what, condition, seconds)


def time_of(what, condition, seconds=PATIENCE_S):
    """Returns when `condition` was seen to hold; it is asked as often as the machine allows."""
    cluster_lib.wait_until(what, condition, seconds, pause_max=0.02)
    return time.time()


class Lab:
    """The namespaces of a run, healed and unshaped between rows."""

    def __init__(self):
        self.lab = faultlab.Lab(NODES)

    def __enter__(self):
        self.lab.__enter__()
        return self

    def __exit__(self, *what):
        self.lab.__exit__(*what)

    def mend(self):
        self.lab.heal()
        for node in range(1, NODES + 1):
            self.lab.shape(node)


class Stage:
    """A row's cluster. Used as a context, it ends everything that was started in it."""

    known_digests = {}  # digests of fault-free runs, for all rows

    def __init__(self, lab, report, logs=None, is_small=True):
        self.lab, self.report, self.logs, self.doubt = lab.lab, report, logs, 0.0
        self.mend = lab.mend
        self.cluster = cluster_lib.Cluster(
            host=self.lab.addr(1), prefix=self.lab.enter)
        self.nodes = {}
        self.is_small = is_small  # rows that repeat a fault do so a few times only
        self.sampler = watch.Sampler()
        self.frames = None
        self.frames_asked = 0  # frames of all animations
        self.has_moved = False  # whether it has shown MOVING
        self.moves = False  # whether the row's scenes move, where it is not about one that stands still
        self.bounds_before = None
        self.clean = contextlib.ExitStack()  # ends what a row has started besides

    def __enter__(self):
        self.cluster.__enter__()
        return self

    def __exit__(self, kind, value, traceback):
        self.clean.close()
        self.mend()
        self.sampler.stop()
        if self.frames:
            self.frames.stop()
        if self.logs and (kind is not None or not self.report.holds):
            kept = pathlib.Path(self.logs, self.report.row)
            shutil.copytree(self.cluster.folder, kept, ignore=shutil.ignore_patterns("*.pfm", "keys"), dirs_exist_ok=True)
        try:
            self.cluster.__exit__(None, None, None)
        except AssertionError:
            if kind is None:  # else what broke the row off is the reason
                raise

    # -- processes
    def serve(self, *options):
        process = self.cluster.serve("--log-format", "json", "--metrics", METRICS, *options)
        self.sampler.follow("master", process.pid)
        return process

    def slave(self, name, node=None, sleep_ms=SLEEP_MS, threads=1, limits=None, options=()):
        """limits: cpu, mem, nofile as for faultlab's run(); then it is the lab's child, and its pid is returned."""
        self.nodes[name] = node or 2 + len(self.nodes) % (NODES - 1)
        words = ["--test-tile-sleep-ms", str(sleep_ms), "--log-format", "json", *options]
        if not limits:
            return self.cluster.slave(name, *words, threads=threads, node=self.nodes[name])
        keys = self.cluster.add_key("slave", name)
        return self.lab.run(self.nodes[name], [
            cluster_lib.program("tessera-slave"), "--master", self.cluster.address, "--keys", keys, "--name", name,
            "--threads", str(threads), *words], log=str(self.log(name)), **limits)

    def slaves(self, count, sleep_ms=SLEEP_MS, **how):
        for i in range(count):
            self.slave(f"slave-{i + 1}", sleep_ms=sleep_ms, **how)
        self.cluster.wait_for_slaves(count)

    def cluster_of(self, count, *options, **how):
        self.serve(*options)
        self.slaves(count, **how)

    def process(self, name):
        return self.cluster.processes[name]

    def pid(self, name):
        return self.process(name).pid

    def log(self, name):
        return self.cluster.folder / f"{name}.log"

    # -- what is known
    def status(self):
        return self.cluster.status()

    def metric(self, name):
        """Returns a value on the master's page of metrics, by name and labels as they stand there."""
        page = subprocess.run([*self.cluster.prefix(1), sys.executable, "-c", READ_PAGE, f"http://{METRICS}/metrics"],
                              capture_output=True, text=True, timeout=PATIENCE_S, check=True).stdout
        return next(float(line.rsplit(" ", 1)[1]) for line in page.splitlines() if line.rsplit(" ", 1)[0] == name)

    def verdicts(self, verdict):
        """Returns how many results of tiles the master has judged so."""
        return self.metric(f'tessera_results_total{{verdict="{verdict}"}}')

    def bounds(self):
        """Returns the bounds as things stand now; the first ones are kept as those before the fault."""
        lines = self.frames.lines if self.frames else []
        now = bounds.Bounds(self.status(), max((line["build_seconds"] for line in lines), default=0.0))
        if self.bounds_before is None:
            self.bounds_before = now
        return now

    def events(self, name, since=0.0, log="master"):
        return [e for e in watch.events(self.log(log), since) if e["event"] == name]

    def first_event(self, name, since, log="master", seconds=PATIENCE_S):
        return wait_until(f"event {name} in {log}'s log", lambda: self.events(name, since, log), seconds)[0]

    def nth_event(self, name, number, log="master", seconds=PATIENCE_S):
        """Returns the event of this number, from 0, among all of that name in the log."""
        return wait_until(f"event {name} number {number} in {log}'s log", lambda: self.events(name, log=log)[number:], seconds)[0]

    # -- frames
    def expected(self, scene, frames, size=FRAME):
        """Returns the digests of a fault-free run in one process."""
        key = (*scene, *size, frames)
        if key not in self.known_digests:
            self.known_digests[key] = self.cluster.render(
                scene[0], *scene[1:], *size, "--frames", f"0:{frames - 1}", "--local", "1", connect=False).digests
        return self.known_digests[key]

    def animate(self, scene=None, frames=12, size=FRAME, options=()):
        """Starts an application in the background, whose frames are timed as they come. scene: None: the row's usual."""
        scene = scene or (MOVING if self.moves else STILL)
        self.expected_digests = self.expected(scene, frames, size)
        self.frames_asked += frames
        self.animate_again = lambda: self.animate(scene, frames, size, options)
        self.has_moved = self.has_moved or scene == MOVING
        self.animation = self.cluster.start_render(scene[0], *scene[1:], *size, "--frames", f"0:{frames - 1}", *options)
        self.sampler.follow("application", self.animation.pid)
        self.frames = watch.Frames(self.animation.tessera[1])
        return self.animation

    def wait_for_frames(self, count, seconds=PATIENCE_S):
        wait_until(f"{count} frames", lambda: len(self.frames.lines) >= count, seconds)

    def wait_for_tiles(self, name):
        return wait_until(f"{name} with tiles", lambda: (self.cluster.slave_status(name) or {}).get("tiles_in_flight"))

    def wait_in_use(self, name, tiles=0, what="in use"):
        """Waits until the slave has done more tiles than that. On a busy machine the others may have rendered all
        frames before it comes; then the animation is shown again."""
        def is_in_use():
            if (self.cluster.slave_status(name) or {}).get("tiles_done", 0) > tiles:
                return True
            if self.animation.poll() is not None:
                self.finish()
                self.animate_again()
            return False
        wait_until(what, is_in_use)

    def finish(self, seconds=PATIENCE_S):
        """Waits for the animation. Checks I1, I2 and I3: every frame, in order, once, and the same to the bit."""
        run = self.cluster.finish(self.animation, seconds)
        self.frames.stop()
        self.report.claim("the application ended well", run.code == 0, run.stderr.strip()[-200:])
        self.report.claim("frames in order, once each",
                          [line["frame"] for line in run.stats] == list(range(len(self.expected_digests))),
                          [line["frame"] for line in run.stats])
        self.report.picture(run.digests == self.expected_digests)
        values = self.report.values
        values["tiles_reissued"] = sum(line["tiles_reissued"] for line in run.stats)
        values["tiles_duplicated"] = sum(line["tiles_duplicated"] for line in run.stats)
        values["tiles_rendered_twice"] = sum(line["tiles_rejected"] for line in run.stats)
        return run

    # -- the oracle that all rows share
    def oracle(self, settled_slaves=None):
        """Checks I4 (memory now, descriptors and threads back) and I7. Call it when fault and frames are over."""
        status = self.status()
        self.report.claim("leases add up (I7)", status["tiles_issued"] == status["tiles_accepted"] + status[
            "tiles_rejected"] + status["tiles_abandoned"] + status["tiles_in_flight"], status)
        grown = self.sampler.peak["master"] - self.sampler.base["master"]["mib"]
        held_up = 2 * MOVING_VERSION_MIB if self.has_moved else 0
        self.report.figure("memory", grown, MEMORY_SLACK_MIB + held_up, "MiB")
        if settled_slaves is not None:
            pid = self.pid("master")
            wanted = self.sampler.base["master"]
            allowed = wanted["fds"] + 2 * settled_slaves
            deadline = time.monotonic() + self.bounds().detection + 1
            while watch.descriptors(pid) > allowed and time.monotonic() < deadline:
                time.sleep(0.02)
            self.report.figure("descriptors", watch.descriptors(pid), allowed, "")
            self.report.figure("threads", watch.threads(pid), wanted["threads"], "")

    def quiet(self, names, seconds=1.0):
        """Checks I5: what waits uses less than 2 % of one core."""
        self.report.figure("waiting", 100 * watch.cpu_share([self.pid(n) for n in names], seconds), 2, "% CPU")

    @property
    def lateness(self):
        """Returns what the machine may add to a reaction since the fault, and the measuring be wrong by."""
        return bounds.allowance(self.sampler.late, self.doubt)

    @property
    def measured_lateness(self):
        """Returns lateness without a floor, for rows about speed."""
        return bounds.measured_allowance(self.sampler.late, self.doubt)

    def usual_mean(self, since, until):
        """Returns the mean time between frames that came within the interval. Seconds."""
        times = [t for t in self.frames.times if since <= t <= until]
        return (times[-1] - times[0]) / max(len(times) - 1, 1)

    def usual_without(self, name, instant):
        """Returns the frame time before `instant`, as it is when this slave's threads are missing. Seconds.

        It is the longest of them, since it is held against the longest gap after the fault, and on a machine that does
        something else the mean of a few frames says little of the next one."""
        times = [t for t in self.frames.times if t < instant]
        threads = self.bounds_before.threads
        rest = sum(n for other, n in threads.items() if other != name)
        return max(b - a for a, b in zip(times[1:], times[2:])) * sum(threads.values()) / rest

    # -- faults
    def _begin(self):
        """Begins a fault: what made an earlier one late, or took long in making it, is no part of this one."""
        self.sampler.mark()
        self.doubt = 0.0

    def kill(self, name, how=signal.SIGKILL):
        """Returns: when the process had ended (its sockets are closed by then)."""
        self._begin()
        process = self.process(name)
        process.send_signal(how)
        process.wait(PATIENCE_S)
        return time.time()

    def now(self):
        self._begin()
        return time.time()

    # Each of these returns a moment before the fault is made or ended; what follows from it cannot lie before that.
    def pause(self, name):
        before = self.now()
        os.kill(self.pid(name), signal.SIGSTOP)
        return before

    def resume(self, name):
        before = time.time()
        os.kill(self.pid(name), signal.SIGCONT)
        return before

    def node_of(self, name):
        return 1 if name == "master" else self.nodes[name]

    def cut(self, name, port=(), **what):
        """what: direction ("in": what it should get is lost, "out": what it sends), longer (IP packets of more bytes)."""
        before = self.now()
        self.lab.cut(self.node_of(name), port=list(port), **what)
        self.doubt = time.time() - before
        return before

    def reset(self, name):
        before = self.now()
        self.lab.reset(self.nodes[name])
        self.doubt = time.time() - before
        return before

    def heal(self, name):
        before = time.time()
        self.lab.heal(self.node_of(name))
        self.doubt = max(self.doubt, time.time() - before)
        return before
