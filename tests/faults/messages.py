# SPDX-License-Identifier: Apache-2.0
"""Rows C, second half: bytes that are corrupt, cut short, too long, endless or nonsense; peers that wait, or flood."""
import json
import random
import subprocess
import time

import peer
import watch
from stage import PATIENCE_S, wait_until

LINK_KIB = 64  # a connection's input buffer (kInputBufferBytes)
SECOND_TRY_PORT = 7999  # port of the relay, on its node's loopback


def through_relay(stage, report, faults, seed_note):
    """A slave behind a relay that damages one of its first connections comes back whole. Returns: seconds it takes.

    faults: words for tcpfault."""
    port = SECOND_TRY_PORT
    before = {pid: watch.descriptors(pid) for pid in [stage.pid("master")]}
    relay = subprocess.Popen([*stage.cluster.prefix(5), *peer.tcpfault(
        "proxy", "--listen", f"127.0.0.1:{port}", "--to", stage.cluster.address, *faults)],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    relay.stdout.readline()
    # Each is another slave, since one that is lost with tiles again and again is held back, as F05 wants.
    name = f"relayed-{len(stage.cluster.processes)}-{seed_note.replace(' ', '-')}"
    keys = stage.cluster.add_key("slave", name)
    slave = stage.cluster.start(name, [
        peer.stages.cluster_lib.program("tessera-slave"), "--master", f"127.0.0.1:{port}", "--keys", keys, "--name", name,
        "--threads", "1", "--test-tile-sleep-ms", "5", "--log-format", "json"], node=5)
    try:
        began = time.time()
        stage.wait_in_use(name, what=f"in use in spite of {seed_note}")
        return time.time() - began
    finally:
        slave.terminate()
        slave.wait(PATIENCE_S)
        relay.terminate()
        relay.wait(PATIENCE_S)
        relay.stdout.close()
        stage.cluster.processes.pop(name, None)
        wait_until("its connections gone", lambda: watch.descriptors(stage.pid("master")) <= before[stage.pid("master")] + 1)


def damage_row(stage, report, kinds, count):
    """Damages at `count` random places of a slave's short session; frames go on and stay right."""
    chance = random.Random(report.seed)
    stage.cluster_of(2, sleep_ms=20)
    stage.animate(frames=count * 8)
    stage.wait_for_frames(2)
    stage.bounds()
    stage.now()
    slowest = 0.0
    for i in range(count):
        kind = kinds[i % len(kinds)]
        direction, connection = chance.choice(["up", "down"]), chance.choice([1, 2])
        at = chance.choice([chance.randrange(1, 400), chance.randrange(400, 4000)])
        words = [kind, at, "--dir", direction, "--conn", connection]
        slowest = max(slowest, through_relay(stage, report, words, f"{kind} {at} {direction} of connection {connection}"))
    report.note(f"{count} places, whole again after {slowest:.1f} s at most")
    stage.animation.terminate()
    stage.cluster.finish(stage.animation)
    stage.frames.stop()
    done = [f["digest"] for f in stage.frames.lines]
    report.picture(done == stage.expected_digests[:len(done)])
    report.claim("master alive", stage.process("master").poll() is None)
    stage.oracle(settled_slaves=2)


def f30(stage, report):
    """One bit flipped on the way, at many places, spoils no picture."""
    damage_row(stage, report, ["--corrupt-at"], 5 if stage.is_small else 40)


def f31(stage, report):
    """Connections cut short by FIN or RST, at many places, spoil no picture."""
    damage_row(stage, report, ["--truncate-at", "--reset-at"], 5 if stage.is_small else 40)


def master_kib(stage):
    return 1024 * watch.resident_mib(stage.pid("master"))


def f32(stage, report):
    """A length field that says 4 GiB, or a byte more than the type allows, closes the link and costs little memory."""
    stage.cluster_of(1)
    keys = stage.cluster.add_key("slave", "fake")
    limit = {"hello": 16 * 1024, "result": 768 * 1024 + 8 * 1024 * 1024}
    for warm in (True, False):  # the first round pays for what every first peer costs
        base = master_kib(stage)
        for name, kind, lies in (("header", peer.HELLO, {"header_bytes": 0xffffffff}),
                                 ("payload", peer.HELLO, {"payload_bytes": 0xffffffff}),
                                 ("one more", peer.HELLO, {"header_bytes": limit["hello"] + 1})):
            link = peer.Link(stage, 5, keys, beats=False)
            sent = stage.now()
            link.say(kind, peer.hello("fake"), **lies)
            ended = link.wait_for_end()
            if not warm:
                report.figure(f"closed ({name})", ended - sent, stage.bounds().rtt + stage.lateness)
            link.close()
        fake = peer.HandSlave(stage, "fake")
        sent = stage.now()
        fake.tile.say(peer.RESULT, {1: 0}, payload_bytes=limit["result"])
        ended = fake.tile.wait_for_end()
        fake.close()
        wait_until("gone", lambda: not stage.cluster.slave_status("fake"))
    report.figure("closed (result)", ended - sent, stage.bounds().rtt + stage.lateness)
    report.figure("memory taken", master_kib(stage) - base, LINK_KIB, "KiB")
    events = [e for e in watch.events(stage.log("master")) if "bytes" in json.dumps(e)]
    report.claim("an event names the size", bool(events), "no event speaks of bytes")


def f33(stage, report):
    """A message that never ends is cut off, before and after the handshake."""
    stage.cluster_of(1)
    b = stage.bounds()
    keys = stage.cluster.add_key("slave", "fake")
    link = peer.Link(stage, 5, keys, beats=False)
    began = stage.now()
    link.say(peer.HELLO, peer.hello("fake"), payload_bytes=0, header_bytes=1000)
    while link.ended_at is None and time.time() - began < 20:
        try:
            link.send(b"\0")
        except OSError:
            break
        time.sleep(0.1)
    report.figure("before the handshake", link.wait_for_end() - began, b.handshake + 0.25 + stage.lateness)
    link.close()
    fake = peer.HandSlave(stage, "fake")
    fake.tile.beats = False
    began = stage.now()
    size = 64 * 1024
    fake.tile.say(peer.RESULT, {1: 0}, payload_bytes=size)
    while fake.tile.ended_at is None and time.time() - began < 30:
        try:
            fake.tile.send(b"\0" * 64)
        except OSError:
            break
        time.sleep(0.1)
    report.figure("after it", fake.tile.wait_for_end() - began, b.message(size) + stage.lateness)
    fake.close()
    report.event("slave-lost", len(stage.events("slave-lost")))


def f34(stage, report):
    """Deep nesting and fields that grow in memory cost the master little."""
    stage.cluster_of(1)
    keys = stage.cluster.add_key("slave", "fake")

    def nested(depth):
        data = b""
        for _ in range(depth):
            data = peer.varint(9 << 3 | 2) + peer.varint(len(data)) + data
        return data

    bodies = {"nested groups": b"\x4b" * 8000, "nested messages": nested(2000), "empty sub-messages": b"\x22\x00" * 4000,
              "packed numbers": peer.header({40: b"\1" * 12000}), "invalid UTF-8": peer.header({**peer.hello("x"), 4: b"\xff\xfe"})}
    warm = peer.Link(stage, 5, keys, beats=False)
    warm.say(peer.HELLO, raw=bodies["nested groups"])
    time.sleep(0.3)
    warm.close()
    for name, body in bodies.items():
        base = master_kib(stage)
        link = peer.Link(stage, 5, keys, beats=False)
        link.say(peer.HELLO, raw=body)
        link.wait_for_end()
        link.close()
        report.figure(name, master_kib(stage) - base, (4 * len(body)) / 1024 + LINK_KIB, "KiB")
    report.claim("master alive", stage.process("master").poll() is None)


def clients(stage, node, *words, wait=PATIENCE_S):
    """Runs a client mode of tcpfault on that node. Returns: its report."""
    run = subprocess.run([*stage.cluster.prefix(node), *peer.tcpfault(*words, "--to", stage.cluster.address)],
                         capture_output=True, text=True, timeout=wait)
    return json.loads(run.stdout)


def f35(stage, report):
    """Garbage, HTTP and a port scan are closed and disturb no slave."""
    stage.cluster_of(1)
    b = stage.bounds()
    slowest, most = 0.0, 0
    stage.now()
    for seed in range(report.seed, report.seed + 8):
        answer = clients(stage, 5, "send", "--random", 4096, "--seed", seed, "--wait", 5)
        report.claim(f"seed {seed} closed", answer["peer"] != "open", answer) if answer["peer"] == "open" else None
        slowest, most = max(slowest, answer["after_ms"] or 1e9), max(most, answer["received"])
    answer = clients(stage, 5, "send", "--hex", b"GET / HTTP/1.1\r\nHost: x\r\n\r\n".hex(), "--wait", 5)
    slowest, most = max(slowest, answer["after_ms"] or 1e9), max(most, answer["received"])
    scan = peer.socket_in(stage, 5)
    scan.connect((stage.cluster.host, stage.cluster.port))
    scan.close()
    report.figure("closed", slowest / 1e3, b.handshake + stage.lateness)
    report.figure("answer", most, 7, "bytes")  # as many as a TLS alert has
    report.claim("slaves unaffected", len(stage.status()["slaves"]) == 1 and not stage.events("slave-lost"))


def f36(stage, report):
    """A peer that sends one byte per second (slowloris) is closed and delays nobody."""
    stage.cluster_of(2)
    stage.animate(frames=8)
    stage.wait_for_frames(2)
    b = stage.bounds()
    stage.now()
    answer = clients(stage, 5, "slow", "--random", 4096, "--interval", 1000)
    report.figure("closed (TLS)", (answer["after_ms"] or 1e9) / 1e3, b.handshake + 1 + stage.lateness)
    keys = stage.cluster.add_key("slave", "fake")
    link = peer.Link(stage, 5, keys, beats=False)
    began = stage.now()
    for byte in peer.record(peer.HELLO, peer.hello("fake")):
        if link.ended_at:
            break
        try:
            link.send(bytes([byte]))
        except OSError:
            break
        time.sleep(1)
    # The listener looks every quarter of a second.
    report.figure("closed (Hello)", link.wait_for_end() - began, b.handshake + 0.25 + stage.lateness)
    link.close()
    stage.finish()
    report.claim("others are not delayed", not stage.events("slave-lost"))


def f37(stage, report):
    """A good slave gets in beside 1,000 idle connections."""
    stage.cluster_of(1)
    b = stage.bounds()
    stage.cluster.add_key("slave", "good")  # made before, since joining is timed
    stage.now()
    idle = subprocess.Popen([*stage.cluster.prefix(5), *peer.tcpfault(
        "idle", "--count", 1000, "--hold", 8, "--to", stage.cluster.address)], stdout=subprocess.PIPE, text=True)
    wait_until("many idle", lambda: watch.descriptors(stage.pid("master")) > 20 or idle.poll() is not None)
    began = time.time()
    stage.slave("good", node=4)
    joined = stage.first_event("slave-joined", began)
    report.figure("a good slave is in", joined["at"] - began, 2 * b.handshake + stage.lateness)
    most = watch.descriptors(stage.pid("master"))
    answer = json.loads(idle.communicate(timeout=PATIENCE_S)[0])
    report.figure("kept", most - stage.sampler.base["master"]["fds"], 64 + 2 * 2, "connections")
    report.claim("all closed at last", answer["still_open"] == 0, answer)
    report.claim("slaves unaffected", not stage.events("slave-lost"), stage.events("slave-lost"))
    stage.oracle(settled_slaves=2)


def refused(stage, reason):
    return stage.metric(f'tessera_connections_refused_total{{reason="{reason}"}}')


def f38(stage, report):
    """A flood of connections, as fast as one machine can, hardly slows frames."""
    stage.cluster_of(2)
    stage.animate(frames=40)
    stage.wait_for_frames(5)
    b = stage.bounds()
    usual, before = (measure(since=stage.frames.times[1]) for measure in (stage.frames.usual, stage.frames.share_rendering))
    lines = len(stage.log("master").read_text().splitlines())
    began = stage.now()
    # On a busy machine it takes some goes until what may come at once is used up.
    answers = [clients(stage, 5, "flood", "--seconds", 5)]
    while refused(stage, "over_rate") == 0 and len(answers) < 5:
        answers.append(clients(stage, 5, "flood", "--seconds", 5))
    ended = time.time()
    report.note(f"{sum(a['connected'] for a in answers)} connections in {ended - began:.1f} s")
    during = stage.frames.share_rendering(since=began, until=ended)
    report.claim("frames end meanwhile", during is not None)
    # What the flood itself, and others, take of this machine makes tiles longer, and is none of the master's doing; what
    # the master does late leaves slaves without tiles.
    report.figure("frame time beside that of its tiles", 1 / max(during or 0, 1e-9), 1.1 / max(before, 1e-9), "")
    report.note(f"{1e3 * usual:.0f} ms a frame before, {1e3 * stage.frames.usual(since=began, until=ended):.0f} ms meanwhile")
    more = len(stage.log("master").read_text().splitlines()) - lines
    # Two kinds of events have kLogLinesMax lines each and a sum in each kLogInterval that begins meanwhile.
    report.figure("log lines", more, 2 * (20 + 1) * (2 + int((ended - began) / 10)), "")
    begun = sum(refused(stage, reason) for reason in ("handshake", "crowded_out"))
    # The burst, and so many connections a second, get as far as a handshake (common/net/accept_rate.h).
    report.figure("handshakes begun", begun, 1024 + 100 * (ended - began + 1), "")
    report.claim("others turned away, and counted", refused(stage, "over_rate") > 0)
    stage.finish()
    report.claim("no slave lost", not stage.events("slave-lost"))
    report.note(f"T_det {b.detection:.2f} s")
    stage.oracle(settled_slaves=2)


ROWS = {"F30": f30, "F31": f31, "F32": f32, "F33": f33, "F34": f34, "F35": f35, "F36": f36, "F37": f37, "F38": f38}
