# SPDX-License-Identifier: Apache-2.0
"""A peer that a test plays by hand: records of the protocol (proto/PROTOCOL.md) over TLS or plain TCP, right or wrong.

Headers are Protocol Buffers messages: here dictionaries from field number to value, written and read without a library.
"""
import hashlib
import queue
import select
import socket
import ssl
import struct
import sys
import threading
import time

import stage as stages

HELLO, WELCOME, JOIN, JOINED, REFUSE, PING, PONG, GOODBYE = range(1, 9)
ANNOUNCE, NEED, CHUNK, BUILT, FAILED, RETIRE, CHUNK_LIST, CHUNK_NEED = range(16, 24)
RELAY_FROM, RELAY_FAILED, SCENE_PROGRESS, RELAY_JOIN = range(24, 28)
FRAME_BEGIN, LEASE, FRAME_END, RESULT, RETURNED = range(32, 37)
SUBMIT, CANCEL, FRAME_CHUNK, FRAME_DONE, STATUS_REQUEST, STATUS_REPLY = range(48, 54)
HEAD = struct.Struct("<4sHHIII")
FLOAT_BYTES, CHANNELS = 4, 3


class Fixed64(int):
    """A number of eight bytes on the wire."""


class Fixed32(float):
    """A float of four bytes on the wire."""


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


def header(fields):
    out = b""
    for number, value in fields.items():
        if isinstance(value, Fixed32):
            out += varint(number << 3 | 5) + struct.pack("<f", value)
        elif isinstance(value, float):
            out += varint(number << 3 | 1) + struct.pack("<d", value)
        elif isinstance(value, Fixed64):
            out += varint(number << 3 | 1) + struct.pack("<Q", value)
        elif isinstance(value, (bytes, str)):
            data = value.encode() if isinstance(value, str) else value
            out += varint(number << 3 | 2) + varint(len(data)) + data
        else:
            out += varint(number << 3) + varint(value)
    return out


def fields_of(data):
    """Returns raw values by field number: int for numbers (also fixed ones), bytes for the rest."""
    found, at = {}, 0

    def number():
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(data):
        key = number()
        kind = key & 7
        if kind == 0:
            found[key >> 3] = number()
        elif kind in (1, 5):
            size = 8 if kind == 1 else 4
            found[key >> 3] = int.from_bytes(data[at:at + size], "little")
            at += size
        else:
            size = number()
            found[key >> 3] = data[at:at + size]
            at += size
    return found


def record(kind, fields=None, payload=b"", raw=None, header_bytes=None, payload_bytes=None):
    """Returns a record for a TLS connection (checksum 0). raw, header_bytes and payload_bytes are lies on demand."""
    head = header(fields or {}) if raw is None else raw
    return HEAD.pack(b"TSSR", 1, kind, len(head) if header_bytes is None else header_bytes,
                     len(payload) if payload_bytes is None else payload_bytes, 0) + head + payload


def socket_in(stage, node):
    """Returns a TCP socket that belongs to that node of the lab, since a thread makes it which has moved there. Where
    there is no lab, all are of this machine."""
    if stage.lab is None:
        return socket.socket()
    made = []

    def make():
        stages.faultlab.setns(stage.lab.node(node)["ns"])
        made.append(socket.socket())

    thread = threading.Thread(target=make)
    thread.start()
    thread.join()
    return made[0]


def tls_context(keys=None, server=False, ca=None):
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER if server else ssl.PROTOCOL_TLS_CLIENT)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    if not server:
        context.check_hostname = False
    context.verify_mode = ssl.CERT_REQUIRED if server or keys else ssl.CERT_NONE
    if keys:
        context.load_cert_chain(f"{keys}/node.crt", f"{keys}/node.key")
        context.load_verify_locations(ca or f"{keys}/ca.crt")
    return context


class Link:
    """One connection. Pings are answered and sent in the background; other messages wait in `heard`."""

    def __init__(self, stage, node, keys=None, tls=True, beats=True, to=None):
        """to: (host, port); the master's where it is not given."""
        self.plain = socket_in(stage, node)
        self.plain.settimeout(5)
        self.plain.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        host, port = to or stage.cluster.address.rsplit(":", 1)
        self.plain.connect((host, int(port)))
        self.address = "{}:{}".format(*self.plain.getsockname()[:2])  # as the other end knows it
        self._begin(tls_context(keys).wrap_socket(self.plain) if tls else self.plain, beats)

    @classmethod
    def over(cls, connected, beats=True):
        """Makes a link over a socket that is connected already (a false relay's)."""
        link = cls.__new__(cls)
        link.plain = connected
        link._begin(connected, beats)
        return link

    def _begin(self, connected, beats):
        self.socket, self.beats = connected, beats
        self.lock, self.heard, self.ended_at, self.is_over = threading.Lock(), queue.Queue(), None, False
        self.born = time.time()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def send(self, data):
        with self.lock:
            self.socket.settimeout(10)
            self.socket.sendall(data)

    def say(self, kind, fields=None, payload=b"", **lies):
        self.send(record(kind, fields, payload, **lies))

    def _read(self):
        data, beat = b"", time.time()
        while not self.is_over:
            try:
                if self.beats and time.time() - beat > 0.2:
                    beat = time.time()
                    self.say(PING, {1: Fixed64(1)})
                if not select.select([self.socket], [], [], 0.05)[0]:
                    continue
                with self.lock:
                    self.socket.settimeout(0.02)
                    more = self.socket.recv(1 << 20)
                if not more:
                    break
                data += more
            except (socket.timeout, ssl.SSLWantReadError):
                continue
            except (OSError, ValueError):
                break
            while len(data) >= HEAD.size:
                _, _, kind, header_bytes, payload_bytes, _ = HEAD.unpack_from(data)
                size = HEAD.size + header_bytes + payload_bytes
                if len(data) < size:
                    break
                one = (kind, fields_of(data[HEAD.size:HEAD.size + header_bytes]), data[HEAD.size + header_bytes:size])
                data = data[size:]
                if kind == PING and self.beats:
                    try:
                        self.say(PONG, {1: Fixed64(one[1].get(1, 0))})
                    except OSError:
                        break
                elif kind not in (PING, PONG):
                    self.heard.put(one)
        self.ended_at = time.time()

    def next(self, seconds):
        """Returns the next message; None when none came in time or the other side has closed."""
        end = time.monotonic() + seconds
        while True:
            has_ended = self.ended_at is not None  # asked first, so that what came before the end is in the queue
            try:
                return self.heard.get(timeout=0.001 if has_ended else min(0.1, max(end - time.monotonic(), 0.001)))
            except queue.Empty:
                if has_ended or time.monotonic() >= end:
                    return None

    def hear(self, kind, seconds=stages.PATIENCE_S):
        """Returns the next message of that kind; others are passed over."""
        end = time.monotonic() + seconds
        while True:
            one = self.next(end - time.monotonic())
            if one is None:
                raise AssertionError(f"no message {kind}: " + (
                    "the link was closed" if self.ended_at else f"none came within {seconds} s"))
            if one[0] == kind:
                return one

    def wait_for_end(self, seconds=stages.PATIENCE_S):
        """Returns: when the other side closed."""
        stages.wait_until("closed by the master", lambda: self.ended_at, seconds)
        return self.ended_at

    def close(self):
        self.is_over = True
        self.reader.join(2)
        self.socket.close()


# Field 3 of FrameSubmit, for a frame of 64 x 48 pixels seen from (0, 0, 3). Numbers that may not be 0 are given: edge
# of a tile (15), samples (16), light samples (17), VPLs (20), edge of the interleaving pattern (21).
SETTINGS = {3: header({1: 64, 2: 48, 5: Fixed32(3), 10: Fixed32(1), 12: Fixed32(40), 15: 16, 16: 1, 17: 1, 20: 1, 21: 1})}


def scene_digest(digests):
    """The digest of a scene whose blocks have these, of 32 bytes each (PROTOCOL.md, SceneBuilt)."""
    group = 256 * 32
    groups = [hashlib.sha256(digests[i:i + group]).digest() for i in range(0, len(digests), group)]
    return hashlib.sha256(b"".join(groups)).digest()


def hello(name, role=0, version=(1, 1), threads=1, isas=15):
    return {1: role, 2: version[0], 3: version[1], 4: name, 5: threads, 6: isas, 7: "by hand"}


class HandSlave:
    """A slave by hand, with keys and both connections, which acknowledges scenes unread; the test says the rest."""

    def __init__(self, stage, name, node=5, extra=None):
        """extra: further fields of its Hello."""
        self.stage, self.name = stage, name
        keys = stage.cluster.add_key("slave", name)
        self.tile = Link(stage, node, keys)
        self.tile.say(HELLO, {**hello(name), **(extra or {})})
        _, welcome, _ = self.tile.hear(WELCOME)
        self.session, self.token = welcome[2], welcome[3]
        self.scene = Link(stage, node, keys)
        self.scene.say(JOIN, {1: welcome[1], 2: Fixed64(welcome[2]), 3: Fixed64(welcome[3])})
        self.scene.hear(JOINED)
        self.begin = None

    def build(self):
        """Acknowledges the next scene announced. Returns: its version."""
        _, announce, payload = self.scene.hear(ANNOUNCE)
        self.scene.say(NEED, {1: announce[1], 2: 0})
        digests = payload[:32 * announce[2]]
        self.scene.say(BUILT, {1: announce[1], 2: 0.001, 3: 4, 4: scene_digest(digests)})
        return announce[1]

    def lease(self, seconds=stages.PATIENCE_S):
        """Returns the next lease, whose frame is known by then."""
        end = time.monotonic() + seconds
        while True:
            one = self.tile.next(end - time.monotonic())
            assert one is not None, "no lease came"
            kind, fields, _ = one
            if kind == FRAME_BEGIN:
                self.begin = fields
            elif kind == LEASE:
                return fields

    def answer(self, lease, pixel=(0.5, 0.5, 0.5), tile_px=16, **other):
        """Returns header and payload of a result for that lease. other: frame=, version=, tile=, attempt= instead."""
        fields = {1: other.get("frame", lease.get(1, 0)), 2: other.get("version", self.begin[2]),
                  3: other.get("tile", lease.get(2, 0)), 4: other.get("attempt", lease[3]), 5: 0.001, 6: 0.0}
        return fields, struct.pack("<3f", *pixel) * (tile_px * tile_px)

    def say_result(self, lease, **how):
        self.tile.say(RESULT, *self.answer(lease, **how))

    def refusal(self, seconds=stages.PATIENCE_S):
        """Returns why the master closes, in its own words."""
        _, fields, _ = self.tile.hear(REFUSE, seconds)
        return fields.get(2, b"").decode()

    def close(self):
        self.tile.close()
        self.scene.close()


def tcpfault(*words):
    return [sys.executable, str(stages.HERE.parent / "faultlab" / "tcpfault.py"), *map(str, words)]
