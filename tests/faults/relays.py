# SPDX-License-Identifier: Apache-2.0
"""F57: a slave that feeds others alters what it passes on, says nothing, dies, or cannot be reached."""
import ssl
import struct
import threading
import time

import moving
import peer
from stage import wait_until

import scene_noise

SIDE_PX = 1024            # 4 MiB that no codec shrinks: four times what is worth a relay (RelayPlan::kBytesMin)
TOKEN = 0x1234567
CHUNK_BYTES = 64 * 1024


class FakeRelay(peer.HandSlave):
    """A slave by hand that says it has every scene, and offers it to others. answer(link, need, bits) serves them."""

    def __init__(self, stage, name, answer, node=5):
        self.answer, self.children, self.asked = answer, [], []
        keys = stage.cluster.add_key("slave", name)
        self.door = peer.socket_in(stage, node)
        self.door.bind((stage.lab.addr(node), 0))
        self.door.listen(8)
        self.context = peer.tls_context(keys, server=True)
        self.is_over = False
        threading.Thread(target=self._accept, daemon=True).start()
        super().__init__(stage, name, node, {9: self.door.getsockname()[1], 10: peer.Fixed64(TOKEN)})

    def _accept(self):
        while not self.is_over:
            try:
                plain, _ = self.door.accept()
                link = peer.Link.over(self.context.wrap_socket(plain, server_side=True), beats=False)
            except (OSError, ssl.SSLError):
                continue
            self.children.append((time.time(), link))
            threading.Thread(target=self._serve, args=(link,), daemon=True).start()

    def _serve(self, link):
        try:
            _, join, _ = link.hear(peer.RELAY_JOIN)
            assert join[1] == TOKEN
            while not self.is_over and link.ended_at is None:
                _, need, bits = link.hear(peer.CHUNK_NEED, 30)
                self.asked.append(need)
                self.answer(link, need, bits)
        except (AssertionError, OSError):
            pass

    def close(self):
        self.is_over = True
        self.door.close()
        for _, link in self.children:
            link.close()
        super().close()


def altered(link, need, bits):
    """Answers with a chunk of the right size and other bytes."""
    index = next(i for i in range(need[3]) if bits[i // 8] >> i % 8 & 1)
    link.say(peer.CHUNK, {1: need[1], 2: need.get(2, 0), 3: index * CHUNK_BYTES}, b"\x55" * CHUNK_BYTES)


def silent(link, need, bits):
    pass


def dead(link, need, bits):
    link.plain.close()
    link.is_over = True


def fed_by(stage, report, name, answer, event, bound, is_cut=False):
    """One honest slave after the other joins, and the fake feeds the first. The frame waits for all three."""
    stage.serve("--relay", "on", "--slaves", "3")
    fake = FakeRelay(stage, f"fake-{name}", answer)
    stage.clean.callback(fake.close)
    scene = (moving.moving_noise if stage.moves else scene_noise.write_scene)(stage.cluster.folder, SIDE_PX)
    sent_before = stage.metric("tessera_scene_bytes_sent_total")
    stage.animate([scene], frames=3)
    fake.build()
    b = stage.bounds()
    if is_cut:
        stage.lab.cut(2, peer=[5])
    began = stage.now()
    stage.slave("slave-1", node=2, sleep_ms=5, options=["--log-level", "debug"])
    told = wait_until(f"{event} ({name})", lambda: stage.events(event, began))
    fed_at = fake.children[0][0] if fake.children else stage.first_event("slave-joined", began)["at"]
    report.figure(f"{name}: given up", told[0]["at"] - fed_at, bound(b) + stage.lateness)
    stage.slave("slave-2", node=3, sleep_ms=5)
    stage.cluster.wait_for_slaves(3)
    fake.close()
    stage.finish()
    sent = (stage.metric("tessera_scene_bytes_sent_total") - sent_before) / 2**20
    whole = int(stage.first_event("scene-received", began, log="slave-1")["bytes"]) / 2**20
    # The master sends the scene to slave-1, which the fake has failed, and to slave-2 unless slave-1 feeds it.
    report.figure(f"{name}: sent by the master", sent, 2 * whole, "MiB")
    report.figure(f"{name}: slaves sent to the fake", len(fake.children), 1, "")
    report.claim(f"{name}: one event", len(stage.events(event)) == 1, stage.events(event))
    return told[0]


def f57_altered(stage, report):
    """A chunk that a relay alters is refused by its digest; its sender is reported and feeds nobody else."""
    event = fed_by(stage, report, "altered", altered, "relay-failed", lambda b: 4 * b.rtt + 0.1)
    report.claim("names fault and feeder", event.get("fault") == "altered" and event.get("feeder") == "fake-altered", event)
    stage.oracle()


def f57_silent(stage, report):
    """A relay that takes what is asked for and says nothing is bypassed."""
    # A feeder is judged over a window of T_hs, by a look each heartbeat; the first begins when it is named.
    fed_by(stage, report, "silent", silent, "relay-bypassed", lambda b: b.handshake + b.heartbeat + 0.1)
    stage.oracle()


def f57_dead(stage, report):
    """A relay that dies while it feeds is bypassed at once."""
    event = fed_by(stage, report, "dead", dead, "relay-failed", lambda b: 4 * b.rtt + 0.1)
    report.claim("names the fault", event.get("fault") == "gone", event)
    stage.oracle()


def f57_unreachable(stage, report):
    """A relay that its child cannot reach is bypassed within T_hs."""
    event = fed_by(stage, report, "unreachable", silent, "relay-failed", lambda b: b.handshake + b.rtt + 0.1, is_cut=True)
    report.claim("names the fault", event.get("fault") == "unreachable", event)
    stage.oracle()


def f57_guarded(stage, report):
    """A relay sends away who has no slave's certificate, a wrong token or asks for what is not there."""
    stage.serve("--relay", "on", "--slaves", "3")
    stage.slave("slave-1", node=2)
    stage.cluster.wait_for_slaves(1)
    scene = scene_noise.write_scene(stage.cluster.folder, SIDE_PX)
    stage.animate([scene], frames=2)
    wait_until("the scene at slave-1", lambda: (stage.cluster.slave_status("slave-1") or {}).get("scene_version"))
    stage.now()
    child = peer.HandSlave(stage, "child", extra={9: 1, 10: peer.Fixed64(1)})
    stage.clean.callback(child.close)
    _, announce, digests = child.scene.hear(peer.ANNOUNCE)
    count = announce[2]
    child.scene.say(peer.NEED, {1: announce[1], 2: count}, struct.pack(f"<{count}I", *range(count)))
    _, named, _ = child.scene.hear(peer.RELAY_FROM)
    place = (named[3].decode(), named[4])
    report.claim("fed by slave-1", place[0] == stage.lab.addr(2), place)

    def visit(keys, token, version, block):
        """Returns: whether it was closed, and whether anything but a refusal was said."""
        try:
            link = peer.Link(stage, 5, keys, beats=False, to=place)
            link.say(peer.RELAY_JOIN, {1: peer.Fixed64(token)})
            link.say(peer.CHUNK_NEED, {1: version, 2: block, 3: 1}, b"\1")
        except OSError:
            return True, False
        try:
            link.wait_for_end(5)
            is_closed = True
        except AssertionError:
            is_closed = False
        told = [one for one in link.heard.queue if one[0] != peer.REFUSE]
        link.close()
        return is_closed, bool(told)

    slave, version, token = str(stage.cluster.keys / "child"), announce[1], named[5]
    for name, keys, its_token, block, event, word in (
            ("no certificate", None, token, 0, "handshake-failed", "did not return a certificate"),
            ("an application's certificate", stage.cluster.add_key("app", "app"), token, 0, "relay-refused", "another role"),
            ("a wrong token", slave, token ^ 1, 0, "relay-refused", "a wrong token"),
            ("a block that is not there", slave, token, count, "relay-refused", "is not here")):
        number = len(stage.events(event, log="slave-1"))
        is_closed, has_told = visit(keys, its_token, version, block)
        report.claim(f"{name}: closed, nothing told", is_closed and not has_told, (is_closed, has_told))
        text = stage.nth_event(event, number, log="slave-1")["text"] if is_closed else "nothing: the link stands"
        report.claim(f"{name}: slave-1 says why", word in text, text)
    # A child may ask before its feeder is told of a version (RelayPlan: a feeder is kept for the next one), and waits.
    is_closed, has_told = visit(slave, token, version + 7, 0)
    report.claim("of a version to come nothing is told", not has_told and not is_closed, (is_closed, has_told))
    is_closed, has_told = visit(slave, token, version, 0)
    report.claim("its own child is fed", has_told and not is_closed, (is_closed, has_told))
    root = digests[:32 * count]
    child.scene.say(peer.BUILT, {1: version, 2: 0.001, 3: 4, 4: peer.scene_digest(root)})
    child.close()
    stage.slave("slave-2", node=3, sleep_ms=5)
    stage.slave("slave-3", node=4, sleep_ms=5)
    stage.finish()
    stage.oracle()


ROWS = {"F57": f57_altered, "F57silent": f57_silent, "F57dead": f57_dead, "F57unreachable": f57_unreachable,
        "F57guarded": f57_guarded}
