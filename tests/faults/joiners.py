# SPDX-License-Identifier: Apache-2.0
"""Rows A, second half: slaves that are slow, late, short of descriptors or of another build; a full disk."""
import resource
import time

import peer
import watch
from network import steady_frame_time
from stage import FRAME, PATIENCE_S, SLEEP_MS, cluster_lib, time_of, wait_until


def f04(stage, report):
    """A slave ten times slower than the rest hardly slows their frames."""
    stage.cluster_of(3)
    without = steady_frame_time(stage, report, "without it")
    stage.slave("slow", node=5, sleep_ms=10 * SLEEP_MS)
    stage.cluster.wait_for_slaves(4)
    stage.now()
    with_it = steady_frame_time(stage, report, "with it")
    report.figure("frame time", with_it, 1.25 * without)
    report.claim("it stays connected", not stage.events("slave-lost"))
    report.note(f"its share: {stage.cluster.slave_status('slow')['tiles_done']} tiles")
    stage.oracle(settled_slaves=4)


def f08(stage, report):
    """A slave that joins in mid-animation disturbs no frame."""
    stage.cluster_of(3)
    stage.animate(frames=24)
    stage.wait_for_frames(8)
    b = stage.bounds()
    before = stage.usual_mean(stage.frames.times[2], stage.frames.times[-1])
    began = stage.now()
    stage.slave("late", node=5)
    joined = stage.first_event("slave-joined", began)
    used = time_of("in use", lambda: (stage.cluster.slave_status("late") or {}).get("tiles_done"))
    report.figure("first tile", used - joined["at"], b.handshake + b.scene + b.rtt + b.tile + stage.lateness)
    stage.wait_for_frames(len(stage.frames.lines) + 2)
    during = max((y - x for x, y in zip(stage.frames.times, stage.frames.times[1:]) if y > began and x < used), default=0)
    report.figure("others' frame time", during, 1.05 * before + b.tile + stage.measured_lateness)
    stage.finish()
    # While scenes change, a slave is late with a tile as it builds, and whoever is idle has it as well.
    lost = report.values["tiles_reissued"] - report.values["tiles_duplicated"]
    report.claim("no tile lost", lost == 0, lost)
    stage.oracle(settled_slaves=4)


def f11(stage, report):
    """A disk that is full while a frame is written is one line, and no file is left."""
    folder = stage.cluster.folder / "full"
    folder.mkdir()
    run = stage.lab.exec(1, ["sh", "-c", f"{cluster_lib.program('tessera-master')} render --quiet --light scene --exposure 0 --renderer direct builtin:cornell --size "
                             f"400x400 -o {folder}/big.pfm; echo code $?; ls {folder}"], tmpfs=[f"{folder}:64k"], timeout=60)
    lines = run.stdout.strip().splitlines()
    report.claim("one line with file and reason", len(lines) == 2 and "big.pfm" in lines[0] and "No space" in lines[0], lines)
    report.claim("exit code 1, no file left", lines[1:] == ["code 1"], lines)


def f12(stage, report):
    """A slave at its limit of descriptors says so, and comes back when the limit is lifted."""
    stage.cluster_of(2)
    stage.animate(frames=16)
    stage.wait_for_frames(3)
    b = stage.bounds()
    pid = stage.pid("slave-2")
    limits = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (watch.descriptors(pid) - 2, limits[1]))
    began = stage.reset("slave-2")
    report.claim("it says why", "open files" in wait_until(
        "a reason in its log", lambda: next((e["text"] for e in stage.events("master-not-there", began, "slave-2")), None)))
    stage.quiet(["slave-2"])
    report.claim("it lives", stage.process("slave-2").poll() is None)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, limits)
    lifted = stage.now()
    joined = stage.first_event("slave-joined", lifted)
    report.figure("back", joined["at"] - lifted, 1.5 * b.reconnect_max + b.handshake + stage.lateness)
    stage.finish()
    stage.oracle(settled_slaves=2)


def f23(stage, report):
    """A slave of another protocol version is refused with both ranges; a wider range is negotiated down."""
    stage.cluster_of(1)
    b = stage.bounds()
    link = peer.Link(stage, 5, stage.cluster.add_key("slave", "future"))
    began = stage.now()
    link.say(peer.HELLO, peer.hello("future", version=(7, 9)))
    _, refuse, _ = link.hear(peer.REFUSE)
    report.figure("refused", time.time() - began, b.rtt + stage.lateness)
    reason = refuse.get(2, b"").decode()
    report.claim("both ranges in the reason", "7 to 9" in reason and "1 to" in reason, reason)
    report.claim("and in the log", any("7 to 9" in e["text"] for e in stage.events("peer-refused", began)))
    link.close()
    minor = peer.Link(stage, 5, stage.cluster.add_key("slave", "minor"))
    minor.say(peer.HELLO, peer.hello("minor", version=(1, 9)))
    _, welcome, _ = minor.hear(peer.WELCOME)
    report.claim("a wider range is negotiated down", welcome[1] >= 1, welcome)
    minor.close()


def f24(stage, report):
    """Slaves of another instruction set are refused, or admitted and their frames marked."""
    stage.serve("--isa", "avx2")
    stage.slave("slave-1")
    stage.cluster.wait_for_slaves(1)
    began = stage.now()
    stage.slave("scalar", options=["--isa", "scalar"])
    line = stage.cluster.wait_for_refusal("scalar")
    report.claim("refused with the reason", "avx2" in line, line)
    report.event("slave-refused", len(stage.events("slave-refused", began)))
    stage.process("master").terminate()
    stage.process("master").wait(PATIENCE_S)
    stage.process("slave-1").terminate()
    stage.process("slave-1").wait(PATIENCE_S)
    stage.serve("--isa", "avx2", "--isa-policy", "mixed")
    stage.slave("slave-1")
    stage.slave("scalar-2", options=["--isa", "scalar"])
    stage.cluster.wait_for_slaves(2)
    run = stage.cluster.render("builtin:cornell", *FRAME)
    report.claim("mixed frames are marked", run.stats[0]["mixed"] is True, run.stats[0]["mixed"])
    alone = stage.cluster.render("builtin:cornell", *FRAME, "--local", "1", connect=False)
    apart = greatest_difference(*(sorted(stage.cluster.folder.glob("out-*.pfm"))[-2:]))
    report.figure("difference", apart, 2.0 ** -10, "of 1")
    report.note(f"digests {'equal' if run.digests == alone.digests else 'differ'}")


def greatest_difference(one, other):
    import array
    values = []
    for path in (one, other):
        data = path.read_bytes()
        for _ in range(3):
            data = data[data.index(b"\n") + 1:]
        values.append(array.array("f", data))
    return max(abs(a - b) for a, b in zip(*values))


ROWS = {"F04": f04, "F08": f08, "F11": f11, "F12": f12, "F23": f23, "F24": f24}
