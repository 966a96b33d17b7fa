# SPDX-License-Identifier: Apache-2.0
"""Peers that break rules, one by one: what each does, and the line of the log that must name it.

A drive takes the Place where it happens, does its harm, and returns the words by which the log may name the peer (one
of them): its name, or its address. PEERS, APPLICATIONS and VISITORS say what each line must be.
"""
import hashlib
import os
import pathlib
import random
import socket
import ssl
import struct
import subprocess

import cluster_lib
import peer


class Place:
    """A cluster on this machine; peer.py takes it for a stage without a lab."""

    lab = None

    def __init__(self, cluster, tiles):
        """tiles: the right pixels of each tile, as a slave sends them."""
        self.cluster, self.tiles = cluster, tiles

    @property
    def door(self):
        return "127.0.0.1", self.cluster.port

    def plain(self, door=None):
        """Returns a TCP connection, and the address that its other end knows it by."""
        link = socket.create_connection(door or self.door, cluster_lib.PATIENCE_S)
        return link, "{}:{}".format(*link.getsockname())

    def link(self, role, name, **how):
        """Returns a connection with a key of that role, and its address."""
        link = peer.Link(self, None, self.cluster.add_key(role, name), **how)
        return link, link.address

    def slave(self, name):
        return peer.HandSlave(self, name)

    def watcher(self, name):
        watcher, address = self.link("app", name)
        watcher.say(peer.HELLO, peer.hello(name, role=2))
        watcher.hear(peer.WELCOME)
        return watcher, address

    def application(self, name):
        application, _ = self.link("app", name)
        application.say(peer.HELLO, peer.hello(name, role=1))
        application.hear(peer.WELCOME)
        return application


ENDED_S = 60  # until a peer is closed: five times the longest silence that a slave is granted, on a busy machine


def said_and_over(link, *names):
    """Waits until the other side has closed. Returns: the names, for the log."""
    try:
        link.wait_for_end(ENDED_S)
    finally:
        link.close()
    return names


def send(link, data):
    """Sends what the other side may have closed to already."""
    try:
        link.send(data)
    except OSError:
        pass


def drained(plain):
    """Reads a plain connection until the other side closes it."""
    try:
        while plain.recv(4096):
            pass
    except OSError:
        pass
    plain.close()


# -- before anybody knows who it is
def sends(data):
    def drive(place, door=None):
        plain, address = place.plain(door)
        plain.sendall(data)
        drained(plain)
        return [address]
    return drive


garbage = sends(random.Random(7).randbytes(4096))
web_browser = sends(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")


def port_scan(place):
    plain, address = place.plain()
    plain.close()
    return [address]


def half_open(place):
    """Says nothing, and waits."""
    plain, address = place.plain()
    drained(plain)
    return [address, "127.0.0.1"]


def trickle(place):
    """Sends a byte now and then of a TLS record that is never whole."""
    plain, address = place.plain()
    plain.settimeout(0.3)
    try:
        for byte in b"\x16\x03\x01\x02\x00" + bytes(500):
            plain.sendall(bytes([byte]))
            try:
                if not plain.recv(100):
                    break
            except TimeoutError:
                pass
    except OSError:
        pass
    plain.close()
    return [address, "127.0.0.1"]


def without_certificate(place, door=None):
    plain, address = place.plain(door)
    try:
        with peer.tls_context().wrap_socket(plain) as link:
            drained(link)
    except OSError:
        pass
    return [address]


def with_keys_of(place, keys, door=None):
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    context.load_cert_chain(f"{keys}/node.crt", f"{keys}/node.key")
    plain, address = place.plain(door)
    with context.wrap_socket(plain) as link:
        drained(link)
    return [address]


def of_another_cluster(place):
    other = place.cluster.folder / "other"
    place.cluster.make_keys("init", str(other))
    place.cluster.make_keys("add", str(other), "slave", "stranger")
    return with_keys_of(place, other / "stranger")


def self_signed(place):
    folder = place.cluster.folder / "self"
    folder.mkdir()
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "30",
                    "-subj", "/OU=slave/CN=self", "-keyout", str(folder / "node.key"), "-out", str(folder / "node.crt")],
                   check=True, capture_output=True)
    return with_keys_of(place, folder)


def expired(place):
    place.cluster.make_keys("add", str(place.cluster.keys), "slave", "old", "--days", "-1")
    return with_keys_of(place, place.cluster.keys / "old")


# -- with good keys, before the handshake is over
def first_words(data_of):
    """A slave that has proven its name, and says this first."""
    def drive(place):
        link, _ = place.link("slave", "guest", beats=False)
        send(link, data_of())
        return said_and_over(link, "'guest'")
    return drive


def never_says_hello(place):
    link, address = place.link("slave", "guest", beats=False)
    return said_and_over(link, "'guest'", address, "127.0.0.1")


def cut_message(place):
    link, address = place.link("slave", "guest", beats=False)
    link.send(peer.record(peer.HELLO, peer.hello("guest"))[:-3])
    link.close()
    return ["'guest'", address]


OTHER_VERSION = peer.record(peer.HELLO, peer.hello("guest", version=(7, 9)))
OVERSIZED_HEAD = peer.record(peer.HELLO, peer.hello("guest"), header_bytes=0xffffffff)
OTHER_MAGIC = b"HTTP" + peer.record(peer.HELLO, peer.hello("guest"))[4:]
UNKNOWN_TYPE = peer.record(4711)
RESULT_FIRST = peer.record(peer.RESULT, {1: 1}, bytes(64))
NESTED_HELLO = peer.record(peer.HELLO, raw=b"\x4b" * 8000)
AS_APPLICATION = peer.record(peer.HELLO, peer.hello("guest", role=1))
WRONG_TOKEN = peer.record(peer.JOIN, {1: 1, 2: peer.Fixed64(99), 3: peer.Fixed64(98)})
NO_THREADS = peer.record(peer.HELLO, peer.hello("guest", threads=0))


def clone(place):
    """Has the key of a slave that is here."""
    link, _ = place.link("slave", "slave-1", beats=False)
    link.say(peer.HELLO, peer.hello("slave-1"))
    return said_and_over(link, "'slave-1'")


# -- slaves
def never_joins(place):
    link, _ = place.link("slave", "half")
    link.say(peer.HELLO, peer.hello("half"))
    link.hear(peer.WELCOME)
    return said_and_over(link, "'half'")


def slave_that(name, act):
    """A slave that is joined and does this. act returns the link on which the master ends it."""
    def drive(place):
        slave = place.slave(name)
        try:
            act(slave)
            slave.tile.wait_for_end(ENDED_S)
        finally:
            slave.close()
        return [f"'{name}'"]
    return drive


def says(kind, fields=None, payload=b""):
    return lambda slave: slave.tile.say(kind, fields, payload)


def leased(answer):
    """The slave gets a lease first."""
    def act(slave):
        slave.build()
        answer(slave, slave.lease())
    return act


def result_never_leased(slave, lease):
    slave.say_result(lease, tile=(lease.get(2, 0) + 5) % 12, attempt=200)


def result_of_wrong_size(slave, lease):
    fields, pixels = slave.answer(lease)
    slave.tile.say(peer.RESULT, fields, pixels[:-4])


def results_again_and_again(slave, lease):
    fields, _ = slave.answer(lease)
    pixels = slave.stage.tiles[lease.get(2, 0)]  # the first one is taken
    for _ in range(300):
        send(slave.tile, peer.record(peer.RESULT, fields, pixels))


def results_that_lie_in_length(slave, lease):
    slave.tile.say(peer.RESULT, slave.answer(lease)[0], payload_bytes=64 << 20)


def not_a_number(place):
    """NaN is no violation: the tile is rendered by another slave, and the event names both."""
    slave = place.slave("nan")
    slave.build()
    slave.say_result(slave.lease(), pixel=(float("nan"), 0, 0))
    slave.tile.hear(peer.FRAME_END)
    slave.tile.say(peer.GOODBYE, {1: "enough"})
    slave.close()
    return ["nan"]


def heartbeat_flood(slave):
    """As many pings as fit, of which none is waited for."""
    flood = 500 * peer.record(peer.PING, {1: peer.Fixed64(1)})
    for _ in range(400):
        if slave.tile.ended_at:
            return
        send(slave.tile, flood)


def says_nothing_more(slave):
    slave.tile.beats = slave.scene.beats = False


def built_another_scene(place):
    slave = place.slave("elsewhere")
    _, announce, _ = slave.scene.hear(peer.ANNOUNCE)
    slave.scene.say(peer.NEED, {1: announce[1], 2: 0})
    slave.scene.say(peer.BUILT, {1: announce[1], 2: 0.001, 3: 4, 4: hashlib.sha256(b"another").digest()})
    # A frame more is rendered without it before it leaves.
    slave.tile.say(peer.GOODBYE, {1: "enough"})
    slave.close()
    return ["'elsewhere'"]


def needs_what_is_not_there(slave):
    _, announce, _ = slave.scene.hear(peer.ANNOUNCE)
    slave.scene.say(peer.NEED, {1: announce[1], 2: 1}, struct.pack("<I", 4_000_000))


def takes_tiles_and_sleeps(place):
    """Holds its tiles until it is said to have stalled; the others render them."""
    slave = place.slave("sleeper")
    slave.build()
    slave.lease()
    log = place.cluster.folder / "master.log"
    cluster_lib.wait_until("said to have stalled", lambda: "slave-stalled" in log.read_text())
    slave.tile.say(peer.GOODBYE, {1: "enough"})
    slave.close()
    return ["'sleeper'"]


# -- who asks for the status
def watcher_says(data):
    def drive(place):
        watcher, _ = place.watcher("watcher")
        send(watcher, data)
        return said_and_over(watcher, "'watcher'")
    return drive


CANCELS = peer.record(peer.CANCEL, {1: 1})
JUNK_REQUEST = peer.record(peer.STATUS_REQUEST, raw=b"\xff" * 40)
NO_RECORD = bytes(40)


def one_watcher_too_many(place):
    """Sixty-five at once: the last one is turned away."""
    watchers = []
    try:
        for _ in range(64):
            watchers.append(place.watcher("crowd")[0])
        last, _ = place.link("app", "last")
        last.say(peer.HELLO, peer.hello("last", role=2))
        return said_and_over(last, "'last'")
    finally:
        for watcher in watchers:
            send(watcher, peer.record(peer.GOODBYE, {1: "enough"}))
            watcher.close()


def asks_and_never_reads(place):
    """Asks for the status as often as it can, and reads no answer."""
    watcher, _ = place.watcher("deaf")
    watcher.is_over = True  # nobody reads any more
    watcher.reader.join()
    request = 2000 * peer.record(peer.STATUS_REQUEST, {1: 1})
    try:
        while True:
            watcher.send(request)
    except OSError:
        watcher.socket.close()
    return ["'deaf'"]


# -- applications
def application_that(name, act):
    def drive(place):
        application = place.application(name)
        try:
            act(application)
            application.wait_for_end(ENDED_S)
        finally:
            application.close()
        return [f"'{name}'"]
    return drive


def submits(fields):
    return lambda application: application.say(peer.SUBMIT, fields)


def five_frames(application):
    for number in range(8):
        send(application, peer.record(peer.SUBMIT, {1: number, 2: 1, **peer.SETTINGS}))


def announces(sizes, digests=None):
    digests = digests or [hashlib.sha256(bytes([i])).digest() for i in range(len(sizes))]
    return peer.record(peer.ANNOUNCE, {1: 1, 2: len(sizes)}, b"".join(digests) + struct.pack(f"<{len(sizes)}Q", *sizes))


def chunk_of_another_digest(place):
    """Is told that its scene failed, and may go on."""
    application = place.application("forger")
    application.send(announces([100]))
    application.hear(peer.NEED)
    application.say(peer.CHUNK, {1: 1, 2: 0, 3: 0}, bytes(100))
    application.hear(peer.FAILED)
    application.say(peer.GOODBYE, {1: "enough"})
    return said_and_over(application, "'forger'")


def chunk_not_asked_for(application):
    application.send(announces([100]))
    application.say(peer.CHUNK, {1: 1, 2: 7, 3: 0}, bytes(100))


NO_PIXELS = {1: 1, 2: 1, 3: peer.header({1: 0, 2: 0})}


def second_application(place):
    first = place.application("first")
    second, _ = place.link("app", "second")
    second.say(peer.HELLO, peer.hello("second", role=1))
    names = said_and_over(second, "'second'")
    first.say(peer.GOODBYE, {1: "enough"})
    first.close()
    return names


# -- at the door of a slave that feeds others
def door_of(pid):
    """Returns where this process listens, as the kernel knows it."""
    sockets = {os.readlink(entry) for entry in pathlib.Path(f"/proc/{pid}/fd").iterdir()}
    for line in pathlib.Path(f"/proc/{pid}/net/tcp").read_text().splitlines()[1:]:
        words = line.split()
        if words[3] == "0A" and f"socket:[{words[9]}]" in sockets:
            return "127.0.0.1", int(words[1].split(":")[1], 16)
    raise AssertionError("it feeds nobody: it listens nowhere")


def at_door(drive, *more):
    """The same as at the master's door, at that of slave-1."""
    return lambda place: drive(place, *more, door=door_of(place.cluster.processes["slave-1"].pid))


def relay_visitor(role, name, data):
    def drive(place):
        link, address = place.link(role, name, beats=False, to=door_of(place.cluster.processes["slave-1"].pid))
        send(link, data)
        return said_and_over(link, address)
    return drive


WRONG_RELAY_TOKEN = peer.record(peer.RELAY_JOIN, {1: peer.Fixed64(1)})
NEED_BEFORE_TOKEN = peer.record(peer.CHUNK_NEED, {1: 1, 2: 0, 3: 1}, b"\1")

# What the peer is, what it does, and the event and words of the line that names it.
STRANGERS = [
    ("garbage bytes", garbage, "handshake-failed", "wrong version number"),
    ("HTTP to the port", web_browser, "handshake-failed", "http request"),
    ("port scan", port_scan, "handshake-failed", ""),
    ("half-open: says nothing", half_open, "handshake-failed", "no complete handshake in time"),
    ("TLS a byte at a time", trickle, "handshake-failed", "no complete handshake in time"),
    ("TLS without certificate", without_certificate, "handshake-failed", "did not return a certificate"),
    ("keys of another cluster", of_another_cluster, "handshake-failed", "another cluster"),
    ("self-signed certificate", self_signed, "handshake-failed", "self"),
    ("expired certificate", expired, "handshake-failed", "expired"),
]
GUESTS = [
    ("no Hello after TLS", never_says_hello, "peer-left-early", "no complete handshake in time"),
    ("Hello of another version", first_words(lambda: OTHER_VERSION), "peer-refused", "speaks protocol versions 7 to 9"),
    ("oversized head", first_words(lambda: OVERSIZED_HEAD), "peer-left-early", "4294967295"),
    ("another magic", first_words(lambda: OTHER_MAGIC), "peer-left-early", "not a Tessera record"),
    ("unknown record type", first_words(lambda: UNKNOWN_TYPE), "peer-left-early", "type"),
    ("cut message", cut_message, "peer-left-early", ""),
    ("TileResult before Hello", first_words(lambda: RESULT_FIRST), "peer-left-early", "type"),
    ("Hello of nested groups", first_words(lambda: NESTED_HELLO), "peer-left-early", "Hello"),
    ("Hello without threads", first_words(lambda: NO_THREADS), "peer-left-early", "threads"),
    ("slave's key, application's role", first_words(lambda: AS_APPLICATION), "peer-refused", "role 'slave'"),
    ("scene connection, wrong token", first_words(lambda: WRONG_TOKEN), "join-refused", "session that does not exist"),
    ("clone with another slave's key", clone, "slave-refused", "in use"),
]
SLAVES = [
    ("never opens its scene connection", never_joins, "slave-lost", "did not come in time"),
    ("Hello twice", slave_that("twice", says(peer.HELLO, peer.hello("twice"))), "slave-lost", "Hello"),
    ("result of a tile never leased", slave_that("guesser", leased(result_never_leased)), "slave-lost", "expelled"),
    ("result of a wrong size", slave_that("short", leased(result_of_wrong_size)), "slave-lost", "expelled"),
    ("result of 64 MiB", slave_that("long", leased(results_that_lie_in_length)), "slave-lost", "67108864"),
    ("the same result 300 times", slave_that("parrot", leased(results_again_and_again)), "slave-lost", "expelled"),
    ("NaN pixels", not_a_number, "faulty-pixels", "tile"),
    ("200,000 heartbeats at once", slave_that("flood", heartbeat_flood), "slave-lost", "Ping"),
    ("falls silent", slave_that("mute", says_nothing_more), "slave-lost", "silent"),
    ("takes tiles, returns none", takes_tiles_and_sleeps, "slave-stalled", "stalled"),
    ("built another scene", built_another_scene, "scene-differs", "another scene"),
    ("needs block 4,000,000", slave_that("greedy", needs_what_is_not_there), "slave-lost", "SceneNeed.blocks"),
    ("submits a frame", slave_that("climber", says(peer.SUBMIT, {1: 1, 2: 1, **peer.SETTINGS})), "slave-lost", "FrameSubmit"),
]
WATCHERS = [
    ("watcher that cancels a frame", watcher_says(CANCELS), "watcher-refused", "FrameCancel"),
    ("watcher with a junk request", watcher_says(JUNK_REQUEST), "watcher-refused", "StatusRequest"),
    ("watcher that sends no record", watcher_says(NO_RECORD), "watcher-refused", "not a Tessera record"),
    ("watcher that never reads", asks_and_never_reads, "watcher-refused", "send queue is full"),
    ("a 65th watcher", one_watcher_too_many, "watcher-refused", "too many"),
]
APPLICATIONS = [
    ("frame without pixels", application_that("flat", submits(NO_PIXELS)), "application-left", "FrameSubmit"),
    ("eight frames at once", application_that("hasty", five_frames), "application-left", "frames submitted at once"),
    ("chunk of another digest", chunk_of_another_digest, "scene-refused", "digest"),
    ("chunk not asked for", application_that("pusher", chunk_not_asked_for), "application-left", "not asked for"),
    ("sends a tile", application_that("tiler", lambda a: a.say(peer.RESULT, {1: 1}, bytes(64))), "application-left", "TileResult"),
    ("a second application", second_application, "application-refused", "busy"),
]
VISITORS = [
    ("relay: garbage bytes", at_door(garbage), "handshake-failed", "wrong version number"),
    ("relay: HTTP", at_door(web_browser), "handshake-failed", "http request"),
    ("relay: TLS without certificate", at_door(without_certificate), "handshake-failed", "did not return a certificate"),
    ("relay: an application's key", relay_visitor("app", "app", WRONG_RELAY_TOKEN), "relay-refused", "another role"),
    ("relay: a wrong token", relay_visitor("slave", "guest", WRONG_RELAY_TOKEN), "relay-refused", "a wrong token"),
    ("relay: asks before it says a token", relay_visitor("slave", "guest", NEED_BEFORE_TOKEN), "relay-refused", "gone"),
]
