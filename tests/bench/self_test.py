#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes a small tree of results and a document, plants differences and expects tables.py --check to go red."""
import contextlib
import io
import json
import math
import pathlib
import re
import sys
import tempfile
import unittest
import unittest.mock
import xml.etree.ElementTree

import tables

RUN = {"commit": "abc1234", "processor": "a processor", "compiler": "a compiler", "date": "2026-01-02", "command": "a command"}
SERIES = {"columns": ["series", "slaves", "frames_per_s", "speed_up", "utilisation", "wire_share", "master_cpu_share",
                      "bytes_per_frame", "tile_px", "limit"],
          "rows": [["near 720p 10 Gbit/s", slaves, 0.5 * slaves, slaves, 1.0, 0.1, 0.2, 1000, 32, "slaves"] for slaves in (1, 10, 100)]
                  + [["near 720p 25 Gbit/s", slaves, 0.4 * slaves, slaves, 1.0, 0.1, 0.2, 1000, 16, "wire"] for slaves in (1, 10, 100)]}
ERROR = [{"scene": "a room", "error": {"rows": [
    {"series": series, "setting": f"{n} VPLs", "cpu_seconds": 0.01 * n, "rmse": 0.1 / n} for series in ("vpls", "clamp") for n in (8, 64)]}}]
CORE = [{"scene": scene, "rays": [{"kind": "primary", "rays": 1000, "rows": [
    {"name": name, "mrays_per_cpu_second": rate, "differ": 0} for name, rate in (("bvh8 fans", 30.0), ("kd8 fans", 15.0), ("embree medium", 20.0))]}]}
    for scene in ("knot", "field")]
ROWS = {"columns": ["", "knot"], "rows": [["camera rays", "1.30 (31.6)"], ["both kinds", "0.94 / 0.85"], ["shadow rays", "0.9 to 1.1 (20)"]]}
DOCUMENT = """# A document

<!-- results: scaling.json speeds 1 100 -->
<!-- end of results -->

<!-- plot: scaling.json frames frames.svg -->
<!-- end of plot -->

<!-- plot: scaling.json speed-up pictures/speed-up.svg -->
<!-- end of plot -->

<!-- plot: light.json error error.svg -->
<!-- end of plot -->

<!-- plot: core.json,rows.json embree rays embree.svg -->
<!-- end of plot -->
"""


class Documents(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.root = pathlib.Path(scratch.name).resolve()
        for name, value in (("ROOT", self.root), ("RESULTS", self.root)):
            patch = unittest.mock.patch.object(tables, name, value)
            patch.start()
            self.addCleanup(patch.stop)
        (self.root / "pictures").mkdir()
        for name, more in (("scaling", {"tables": {"series": SERIES}}), ("light", {"gi": ERROR}), ("core", {"core": CORE}),
                           ("rows", {"tables": {"rays": ROWS}})):
            (self.root / f"{name}.json").write_text(json.dumps({"run": RUN, **more}))
        self.document = self.root / "a.md"
        self.document.write_text(DOCUMENT)

    def check(self):
        """(exit code, what was said)"""
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            code = tables.main(["--check"])
        return code, said.getvalue()

    def write(self):
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(tables.main([]), 0)

    def test_what_was_written_is_green(self):
        self.assertEqual(self.check()[0], 1)
        self.write()
        self.assertEqual(self.check(), (0, "1 tables, 4 plots, 0 files differ\n"))
        self.assertIn("| near 720p 25 Gbit/s | 0.40 (16) | 40.00 (16) | 100 at 100 | wire: wire 10 %, master 20 %, slaves 100 % | 1,000 |",
                      self.document.read_text())
        self.assertIn("![Speed-up over slaves](pictures/speed-up.svg)", self.document.read_text())

    def test_a_planted_difference_is_red(self):
        self.write()
        for name, old, new in (("a.md", "40.00", "41.00"), ("a.md", "![Speed-up", "![Speed"), ("frames.svg", "cy=\"", "cy=\"1"),
                               ("embree.svg", "1.30", "1.40")):
            text = (self.root / name).read_text()
            self.assertIn(old, text)
            (self.root / name).write_text(text.replace(old, new, 1))
            code, said = self.check()
            self.assertEqual((code, said.splitlines()[0]), (1, f"{name} is not what tables.py makes of its results"))
            (self.root / name).write_text(text)
        (self.root / "error.svg").unlink()
        self.assertEqual(self.check()[0], 1)

    def test_another_result_is_red_in_its_picture_alone(self):
        self.write()
        result = json.loads((self.root / "light.json").read_text())
        result["gi"][0]["error"]["rows"][0]["rmse"] *= 1.1
        (self.root / "light.json").write_text(json.dumps(result))
        self.assertEqual(self.check(), (1, "error.svg is not what tables.py makes of its results\n1 tables, 4 plots, 1 files differ\n"))

    def test_pictures_hold_each_series_and_ratio(self):
        self.write()
        found = {}
        for path in self.root.rglob("*.svg"):
            names = [element.tag.rpartition("}")[2] for element in xml.etree.ElementTree.parse(path).iter()]
            found[path.name] = [names.count(name) for name in ("polyline", "circle")]
        # Two series of three places in two panels, and their legend; one line and one series of marks, of two places.
        self.assertEqual(found["frames.svg"], [4, 14])
        self.assertEqual(found["speed-up.svg"], [5, 14])
        self.assertEqual(found["error.svg"][0], 1)
        words = (self.root / "embree.svg").read_text()
        for ratio in (">1.50<", ">0.75<", ">1.30<", ">1.00<"):
            self.assertIn(ratio, words)
        self.assertNotIn("both kinds", words)

    def test_what_is_not_there_is_named(self):
        for mark, words in (("<!-- plot: light.json pie a.svg -->\n<!-- end of plot -->\n", "no plot 'pie'"),
                            ("<!-- results: rows.json none -->\n<!-- end of results -->\n", "no table or view 'none'"),
                            ("<!-- plot: light.json error a.svg -->\n", "a mark without its end")):
            self.document.write_text(mark)
            with self.assertRaisesRegex(SystemExit, words):
                tables.main(["--check"])


class PacketLimits(unittest.TestCase):
    """The limits of a packet's work in the kernels are those that the measured tables yield."""

    def test_limits_follow_from_what_was_measured(self):
        measured = json.loads((tables.RESULTS / "trials-packets-limits.json").read_text())["tables"]
        kernel = (tables.ROOT / "slave/core/traverse/bvh_packet-inl.h").read_text()
        of_any, of_closest = map(int, re.search(r"kWorkMax = Leaf::kIsAny \? (\d+) : (\d+);", kernel).groups())
        for table, limit in (("closest", of_closest), ("any", of_any)):
            times = {int(row[0]): math.prod(map(float, row[1:])) ** (1 / len(row[1:]))
                     for row in measured[table]["rows"] if row[0].isdigit()}
            self.assertGreater(len(times), 4)
            self.assertEqual(limit, max(key for key, time in times.items() if time <= 1.01 * min(times.values())), table)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
