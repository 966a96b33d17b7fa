# SPDX-License-Identifier: Apache-2.0
"""Rows D: peers without credentials, with wrong ones, or in a role that is not theirs are refused."""
import json
import shutil
import socket
import ssl
import subprocess
import time

import peer
from stage import PATIENCE_S, time_of, wait_until


def first_bytes(stage, link_of, report, name, b):
    """The connection is closed within T_hs, and nothing of ours was understood."""
    began = stage.now()
    try:
        link = link_of()
    except (OSError, ValueError):  # TLS itself refuses the peer
        report.figure(f"closed ({name})", time.time() - began, b.handshake + stage.lateness)
        return
    try:
        link.say(peer.HELLO, peer.hello("fake"))
    except OSError:
        pass
    ended = link.wait_for_end()
    report.figure(f"closed ({name})", ended - began, b.handshake + 0.25 + stage.lateness)
    report.claim(f"no message answered ({name})", link.heard.empty())
    link.close()


def f39(stage, report):
    """A peer without credentials is closed: plain bytes, TLS without a certificate."""
    stage.cluster_of(1)
    b = stage.bounds()
    first_bytes(stage, lambda: peer.Link(stage, 5, tls=False, beats=False), report, "plain", b)
    first_bytes(stage, lambda: peer.Link(stage, 5, keys=None, beats=False), report, "no certificate", b)
    report.claim("events", len(stage.events("handshake-failed")) >= 2, stage.events("handshake-failed"))
    report.claim("slaves unaffected", not stage.events("slave-lost"))


def wrong_keys(stage):
    """Makes credentials that must not work. Returns: name -> (folder, what the refusal speaks of)."""
    cluster = stage.cluster
    keys_tool = peer.stages.cluster_lib.program("tessera-keys")

    def make(*words):
        subprocess.run([keys_tool, *words], check=True, stdout=subprocess.DEVNULL)

    made = {}
    for name, when in (("expired", ("--days", "-1")), ("early", ("--test-starts-in-days", "2"))):
        make("add", str(cluster.keys), "slave", name, *when)
        made[name] = (cluster.keys / name, "expired" if name == "expired" else "not valid yet")
    other = cluster.folder / "other-keys"
    make("init", str(other))
    make("add", str(other), "slave", "stranger")
    made["other cluster"] = (other / "stranger", "another cluster")
    self_made = cluster.folder / "self"
    self_made.mkdir()
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "30",
                    "-subj", "/OU=slave/CN=self", "-keyout", str(self_made / "node.key"), "-out", str(self_made / "node.crt")],
                   check=True, capture_output=True)
    shutil.copy(cluster.keys / "master" / "ca.crt", self_made / "ca.crt")
    made["self-signed"] = (self_made, "self")
    return made


def good_handshake(stage, times=5):
    """Returns: seconds from connecting to Welcome of a peer with good credentials, the slowest of some now."""
    return max(one_handshake(stage) for _ in range(times))


def one_handshake(stage):
    began = time.time()
    link = peer.Link(stage, 5, stage.cluster.add_key("app", "measure"))
    link.say(peer.HELLO, peer.hello("measure", role=2))
    link.hear(peer.WELCOME)
    took = time.time() - began
    link.close()
    return took


def f40(stage, report):
    """Certificates expired, not yet valid, foreign, self-signed, of the wrong role or revoked are refused."""
    stage.cluster_of(1)
    b = stage.bounds()
    made = wrong_keys(stage)
    good = good_handshake(stage)
    ca = stage.cluster.keys / "master" / "ca.crt"
    for name, (folder, word) in made.items():
        began, told = stage.now(), len(stage.events("handshake-failed"))
        try:
            link = peer.Link.__new__(peer.Link)
            link.plain = peer.socket_in(stage, 5)
            link.plain.settimeout(5)
            link.plain.connect((stage.cluster.host, stage.cluster.port))
            link._begin(peer.tls_context(folder, ca=ca).wrap_socket(link.plain), beats=False)
            try:
                link.say(peer.HELLO, peer.hello("fake"))
            except OSError:  # it has heard the end already
                pass
            _, refuse, _ = link.hear(peer.REFUSE)
            report.claim(f"it is told why ({name})", word in refuse.get(2, b"").decode(), refuse)
            ended = link.wait_for_end()
            report.claim(f"nothing else answered ({name})", link.heard.empty())
            link.close()
        except (OSError, ValueError) as error:
            ended = time.time()
            report.claim(f"it is told why ({name})", False, repr(error))
        report.figure(f"refused ({name})", ended - began, b.rtt + good + stage.lateness)
        # The event is found by its number: that of the peer before may be of the same millisecond, to which the log
        # rounds.
        event = stage.nth_event("handshake-failed", told)
        report.claim(f"the event says why ({name})", word in event["text"], event["text"])
    role(stage, report, "wrong role", stage.cluster.add_key("app", "an-app"), 0)
    revoked(stage, report)
    report.claim("slaves unaffected", not [e for e in stage.events("slave-lost") if "slave-1" in e["text"]])


def revoked(stage, report):
    """A slave with an open session is revoked: it goes within the reload interval, and does not come back."""
    stage.slave("thief", node=4)
    wait_until("in", lambda: stage.cluster.slave_status("thief"))
    run = subprocess.run([peer.stages.cluster_lib.program("tessera-keys"), "revoke", str(stage.cluster.keys), "thief"],
                         capture_output=True, text=True)
    if run.returncode != 0:
        report.claim("revoked", False, "tessera-keys has no revoke: " + run.stderr.strip())
        stage.process("thief").terminate()
        return
    began = stage.now()
    stage.process("master").send_signal(1)
    gone = time_of("the revoked slave is gone", lambda: not stage.cluster.slave_status("thief"), 70)
    report.figure("revocation", gone - began, 60, "ms")
    time.sleep(1)
    report.claim("and stays away", not stage.cluster.slave_status("thief"))
    thief = stage.cluster.processes.pop("thief")
    thief.terminate()
    thief.wait(PATIENCE_S)


def role(stage, report, name, keys, claimed):
    """A peer whose certificate has another role than its Hello claims is refused."""
    began = stage.now()
    link = peer.Link(stage, 5, keys)
    link.say(peer.HELLO, peer.hello("fake", role=claimed))
    _, refuse, _ = link.hear(peer.REFUSE)
    ended = link.wait_for_end()
    report.claim(f"refused by role ({name})", refuse.get(1) == 2 or b"role" in refuse.get(2, b""), refuse)
    report.figure(f"refused ({name})", ended - began, stage.bounds().rtt + good_handshake(stage) + stage.lateness)
    report.claim(f"an event ({name})", len(stage.events("peer-refused", began)) == 1)
    link.close()


def f43(stage, report):
    """A slave that acts as an application is refused, and an application that acts as a slave."""
    stage.cluster_of(1)
    role(stage, report, "slave as application", stage.cluster.add_key("slave", "climber"), 1)
    role(stage, report, "application as slave", stage.cluster.add_key("app", "impostor"), 0)
    fake = peer.HandSlave(stage, "fake")
    sent = stage.now()
    fake.tile.say(peer.SUBMIT, {1: 1, 2: 1})
    ended = fake.tile.wait_for_end()
    report.figure("submit by a slave", ended - sent, stage.bounds().rtt + stage.lateness)
    fake.close()
    report.event("slave-lost", len(stage.events("slave-lost")))


def pem_of(certificate):
    return ssl.DER_cert_to_PEM_cert(certificate).split()


def shown_by_master(stage):
    """Returns the certificate that the master shows to one that connects now, as the words of a PEM file."""
    link = peer.Link(stage, 5, stage.cluster.add_key("app", "measure"))
    certificate = link.socket.getpeercert(binary_form=True)
    link.close()
    return pem_of(certificate)


def shown_by_slave(stage, name):
    """Kills the master and takes its place. Returns the certificate that the slave shows when it comes back."""
    stage.kill("master")
    context = peer.tls_context(stage.cluster.keys / "master", server=True)
    with peer.socket_in(stage, 1) as door:
        door.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        door.bind((stage.cluster.host, stage.cluster.port))
        door.listen(8)
        door.settimeout(PATIENCE_S)
        while True:
            plain, address = door.accept()
            plain.settimeout(PATIENCE_S)
            try:
                with context.wrap_socket(plain, server_side=True) as link:
                    if address[0] == stage.lab.addr(stage.nodes[name]):
                        return pem_of(link.getpeercert(binary_form=True))
            except OSError:  # it had gone meanwhile
                plain.close()


def f41(stage, report):
    """Keys and certificates of master and slave are renewed while frames are rendered."""
    stage.cluster_of(2)
    stage.animate(frames=16)
    stage.wait_for_frames(3)
    began = stage.now()
    tool = peer.stages.cluster_lib.program("tessera-keys")
    for name in ("slave-1", "master"):
        run = subprocess.run([tool, "renew", str(stage.cluster.keys), name], capture_output=True, text=True)
        if not report.claim(f"{name} renewed", run.returncode == 0, run.stderr.strip()):
            stage.finish()
            return
        stage.process(name).send_signal(1)
        stage.first_event("credentials-reloaded", began, log=name)
    report.claim("open sessions live on", not stage.events("slave-lost"), stage.events("slave-lost"))
    began = stage.reset("slave-1")
    stage.first_event("slave-joined", began)
    renewed = {name: (stage.cluster.keys / name / "node.crt").read_text().split() for name in ("slave-1", "master")}
    report.claim("new connections show the master's new certificate", shown_by_master(stage) == renewed["master"])
    stage.finish()
    stage.oracle(settled_slaves=2)
    report.claim("the slave comes back with its new one", shown_by_slave(stage, "slave-1") == renewed["slave-1"])


def f42(stage, report):
    """A recorded session sent again is refused, and a scene connection that joins a session not its own."""
    stage.cluster_of(1)
    b = stage.bounds()
    folder = stage.cluster.folder / "recorded"
    relay = subprocess.Popen([*stage.cluster.prefix(5), *peer.tcpfault(
        "record", "--listen", "127.0.0.1:7998", "--to", stage.cluster.address, "--out", folder)],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    relay.stdout.readline()
    keys = stage.cluster.add_key("slave", "recorded")
    slave = stage.cluster.start("recorded", [
        peer.stages.cluster_lib.program("tessera-slave"), "--master", "127.0.0.1:7998", "--keys", keys, "--name", "recorded",
        "--threads", "1"], node=5)
    wait_until("recorded", lambda: stage.cluster.slave_status("recorded"))
    slave.terminate()
    slave.wait(PATIENCE_S)
    relay.terminate()
    relay.wait(PATIENCE_S)
    relay.stdout.close()
    stage.cluster.processes.pop("recorded")
    good = good_handshake(stage)
    for stream in ("1.up", "2.up"):
        began = stage.now()
        run = subprocess.run([*stage.cluster.prefix(5), *peer.tcpfault(
            "send", "--file", folder / stream, "--wait", 5, "--to", stage.cluster.address)], capture_output=True, text=True)
        answer = json.loads(run.stdout)
        report.figure(f"refused ({stream})", (answer["after_ms"] or 1e9) / 1e3, b.rtt + good + stage.lateness)
        report.claim(f"an event ({stream})", len(stage.events("handshake-failed", began)) >= 1)
    victim = peer.HandSlave(stage, "victim")
    thief = peer.Link(stage, 4, stage.cluster.add_key("slave", "thief"))
    thief.say(peer.JOIN, {1: 1, 2: peer.Fixed64(victim.session), 3: peer.Fixed64(victim.token)})
    _, refuse, _ = thief.hear(peer.REFUSE)
    report.claim("another certificate cannot join", b"session" in refuse.get(2, b"") or refuse.get(1), refuse)
    report.claim("the victim lives", victim.tile.ended_at is None)
    thief.close()
    victim.close()


ROWS = {"F39": f39, "F40": f40, "F41": f41, "F42": f42, "F43": f43}
