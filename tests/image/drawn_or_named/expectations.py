# SPDX-License-Identifier: Apache-2.0
"""Says what a case of the corpus expects, and how two pictures are compared."""
import struct
import sys


class Picture:
    """A colour PFM: rows from the top, linear values."""

    def __init__(self, path):
        data = path.read_bytes()
        kind, size, scale, body = data.split(b"\n", 3)
        assert kind == b"PF" and float(scale) < 0, path
        self.width, self.height = map(int, size.split())
        values = struct.unpack(f"<{3 * self.width * self.height}f", body)
        rows = [values[3 * self.width * y:3 * self.width * (y + 1)] for y in range(self.height)]
        self.rows = rows[::-1]

    def mean(self, left=0.0, top=0.0, right=1.0, bottom=1.0):
        """Returns mean red, green and blue of a part, which is given by shares of the sides."""
        sums, count = [0.0, 0.0, 0.0], 0
        for y in range(int(top * self.height), int(bottom * self.height)):
            for x in range(int(left * self.width), int(right * self.width)):
                count += 1
                for c in range(3):
                    sums[c] += self.rows[y][3 * x + c]
        return [s / count for s in sums]

    def grey(self, *part):
        return sum(self.mean(*part)) / 3

    def difference(self, other):
        """Returns the mean absolute difference, relative to the mean of the other."""
        total = sum(abs(a - b) for mine, theirs in zip(self.rows, other.rows) for a, b in zip(mine, theirs))
        mean = sum(sum(row) for row in other.rows)
        return total / max(mean, 1e-9)


# A check says what is wrong with `a`, the picture with the key, beside `b`, the one without; None when nothing is.

def same(tolerance=0.01):
    def check(a, b):
        d = a.difference(b)
        return None if d <= tolerance else f"differs by {d:.4f} of the mean from the equal file; at most {tolerance}"
    return check


def differs(least=0.01):
    def check(a, b):
        d = a.difference(b)
        return None if d >= least else f"differs by {d:.5f} of the mean; at least {least}"
    return check


def brighter(factor=1.03, part=(0, 0, 1, 1)):
    def check(a, b):
        x, y = a.grey(*part), b.grey(*part)
        return None if x >= factor * y else f"has a mean of {x:.4f} beside {y:.4f}; at least {factor} times"
    return check


def darker(factor=0.97, part=(0, 0, 1, 1)):
    def check(a, b):
        x, y = a.grey(*part), b.grey(*part)
        return None if x <= factor * y else f"has a mean of {x:.4f} beside {y:.4f}; at most {factor} times"
    return check


def colour(channel, factor=1.1, part=(0, 0, 1, 1)):
    """The share of a channel rises at least by the factor."""
    def check(a, b):
        def share(p):
            m = p.mean(*part)
            return m[channel] / max(sum(m), 1e-9)
        x, y = share(a), share(b)
        return None if x >= factor * y else f"has a share of {x:.4f} in channel {channel} beside {y:.4f}; at least {factor} times"
    return check


def both(*checks):
    def check(a, b):
        for one in checks:
            wrong = one(a, b)
            if wrong:
                return wrong
        return None
    return check


LEFT, RIGHT = (0.2, 0.3, 0.45, 0.7), (0.55, 0.3, 0.8, 0.7)


class Case:
    """One key. `make` changes a file of the suffix's kind; `base` makes that to compare with (none: the plain dome)."""

    def __init__(self, key, state, make, check=None, base=None, says=None, why=None, suffix=".gltf"):
        self.key, self.state, self.make, self.check, self.base = key, state, make, check, base
        self.says, self.why, self.suffix = says, why, suffix


CASES = []


def _add(*arguments, **more):
    case = Case(*arguments, **more)
    if any(known.key == case.key for known in CASES):
        sys.exit(f"two cases are called {case.key}")
    CASES.append(case)


def drawn(key, make, check, base=None, suffix=".gltf", why=None):
    """The picture differs from that of `base` as `check` says."""
    _add(key, "drawn", make, check, base, suffix=suffix, why=why)


def named(key, make, says, base=None):
    """One line of the program holds `says`."""
    _add(key, "named", make, None, base, says=says)


def refused(key, make, says, suffix=".gltf"):
    """The file is not drawn, and the line holds `says`."""
    _add(key, "refused", make, None, None, says=says, suffix=suffix)


def silent(key, make, why, base=None):
    """The picture is the same, and rightly so."""
    _add(key, "no picture", make, same(0), base, why=why)


class case_of:
    """Adds cases of another format by the same words; their keys begin with its name."""

    def __init__(self, suffix):
        self.suffix, self.name = suffix, suffix[1:].upper() + ": "

    def drawn(self, key, make, check, base=None):
        _add(self.name + key, "drawn", make, check, base, suffix=self.suffix)

    def named(self, key, make, says):
        _add(self.name + key, "named", make, None, None, says=says, suffix=self.suffix)

    def silent(self, key, make, why, base=None):
        _add(self.name + key, "no picture", make, same(0), base, why=why, suffix=self.suffix)
