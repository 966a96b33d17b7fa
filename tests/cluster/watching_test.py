#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Metrics, status, a trace and its picture, and the dashboard that draws the metrics show a cluster as it is."""
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest
import urllib.error
import urllib.request

import cluster_lib

DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"
SLAVES, THREADS, FRAMES = 3, 2, 6
SAMPLE = re.compile(r'([a-zA-Z_:][a-zA-Z0-9_:]*)(\{(?:[a-zA-Z_]\w*="(?:[^"\\]|\\.)*",?)*\})? (\S+)')
# Words of PromQL that are no metrics.
PROMQL = {"rate", "increase", "histogram_quantile", "sum", "by", "avg", "outcome", "reason", "job", "le", "and", "s", "m"}


def scrape(port, path="/metrics"):
    with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=cluster_lib.PATIENCE_S) as answer:
        return answer.headers["Content-Type"], answer.read().decode()


def samples_of(page):
    samples = {}
    for line in page.splitlines():
        if not line.startswith("#"):
            name, labels, value = SAMPLE.fullmatch(line).groups()
            samples[name + (labels or "")] = float(value)
    return samples


def thread_facts(task):
    """Returns the niceness of a thread, and on how many processors it may run."""
    nice = int((task / "stat").read_text().rpartition(")")[2].split()[16])
    allowed = re.search(r"Cpus_allowed:\s+(\S+)", (task / "status").read_text()).group(1)
    return nice, int(allowed.replace(",", ""), 16).bit_count()


class Watching(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cluster_lib.Cluster()
        cls.cluster.__enter__()
        cls.addClassCleanup(cls.cluster.__exit__, None, None, None)
        cls.trace_path = cls.cluster.folder / "trace.json"
        cls.page_port, cls.slave_port = cluster_lib.free_port(), cluster_lib.free_port()
        master = cls.cluster.serve("--metrics", f"127.0.0.1:{cls.page_port}", "--trace", str(cls.trace_path))
        for i in range(SLAVES):
            also = [["--metrics", f"127.0.0.1:{cls.slave_port}"], ["--nice", "5", "--cores", "1"], []][i]
            cls.cluster.slave(f"slave-{i + 1}", "--test-tile-sleep-ms", "5", *also, threads=THREADS)
        cluster_lib.wait_until("all there", lambda: len(cls.cluster.status()["slaves"]) == SLAVES)
        # Until a ping is answered, no clock is known, and tiles cannot be placed in a trace.
        cluster_lib.wait_until("round trips", lambda: all(s["rtt_seconds"] > 0 for s in cls.cluster.status()["slaves"]))
        cls.run_ = cls.cluster.render("builtin:cornell", "--size", "160x120", "--tile", "16", "--frames", f"0:{FRAMES - 1}")
        cls.modest = cls.cluster.processes["slave-2"].pid  # all its threads have run by now
        cls.modest_threads = [thread_facts(task) for task in pathlib.Path(f"/proc/{cls.modest}/task").iterdir()]
        cls.content_type, cls.page = scrape(cls.page_port)
        cls.slave_page = scrape(cls.slave_port)[1]
        cls.status = cls.cluster.status()
        cls.table = subprocess.run(
            [cluster_lib.program("tessera-master"), "status", "--connect", cls.cluster.address, "--keys",
             cls.cluster.add_key("app", "app")], capture_output=True, text=True, timeout=cluster_lib.PATIENCE_S).stdout
        try:
            scrape(cls.page_port, "/elsewhere")
        except urllib.error.HTTPError as error:
            cls.elsewhere = error.code
        master.terminate()  # the master writes the trace as it ends
        assert master.wait(cluster_lib.PATIENCE_S) == 0
        cls.trace = json.loads(cls.trace_path.read_text())

    def test_the_page_is_what_prometheus_reads(self):
        self.assertEqual(self.content_type, "text/plain; version=0.0.4; charset=utf-8")
        self.assertEqual(self.elsewhere, 404)
        samples, kinds = {}, {}
        for page in (self.page, self.slave_page):
            for line in page.splitlines():
                if line.startswith("# TYPE"):
                    _, _, name, kind = line.split()
                    kinds[name] = kind
                elif not line.startswith("#"):
                    name = SAMPLE.fullmatch(line).group(1)
                    family = next((name[: -len(s)] for s in ("_bucket", "_sum", "_count")
                                   if name.endswith(s) and name[: -len(s)] in kinds), name)
                    self.assertIn(family, kinds, line)
            samples.update(samples_of(page))
        self.assertEqual(samples['tessera_frames_total{outcome="done"}'], FRAMES)
        self.assertEqual(samples["tessera_slaves"], SLAVES)
        self.assertEqual(samples["tessera_render_connected"], 1)
        self.assertGreater(samples["tessera_render_tile_seconds_count"], 0)

    def test_every_lease_is_accounted_for(self):
        samples = samples_of(self.page)
        tiles = {end: samples[f"tessera_tiles_{end}"] for end in
                 ("issued_total", "accepted_total", "rejected_total", "abandoned_total", "in_flight")}
        self.assertEqual(tiles.pop("issued_total"), sum(tiles.values()))
        self.assertEqual(tiles["accepted_total"], FRAMES * 10 * 8)
        for slave in self.status["slaves"]:
            self.assertEqual(slave["tiles_issued"], slave["tiles_accepted"] + slave["tiles_rejected"] +
                             slave["tiles_abandoned"] + slave["tiles_in_flight"], slave)
        for key in ("issued", "accepted", "rejected", "abandoned"):
            self.assertEqual(self.status[f"tiles_{key}"], sum(s[f"tiles_{key}"] for s in self.status["slaves"]), key)

    def test_the_table_is_for_people(self):
        lines = self.table.splitlines()
        self.assertRegex(lines[0], rf"^{SLAVES} slaves, .* frames: {FRAMES} done, 0 failed, 0 cancelled; slaves lost: 0$")
        self.assertRegex(lines[1], r"^tiles: \d+ issued = \d+ accepted \+ \d+ rejected \+ \d+ abandoned \+ 0 in flight")
        self.assertEqual([line.split()[0] for line in lines[3:]], [f"slave-{i + 1}" for i in range(SLAVES)])
        self.assertEqual({len(line) for line in lines[2:]}, {len(lines[2])}, "columns stand below each other\n" + self.table)

    def test_a_modest_slave_renders_below_others_and_on_its_cores(self):
        nices = [nice for nice, _ in self.modest_threads]
        self.assertEqual({cores for _, cores in self.modest_threads}, {1})
        self.assertGreaterEqual(nices.count(5), THREADS, nices)  # the render threads and the main thread
        self.assertGreaterEqual(nices.count(os.nice(0)), 1, "the net thread keeps its priority")
        # The builder has the priority of the render threads, and gives way to them by itself.
        self.assertEqual(nices.count(5), THREADS + 2, nices)
        self.assertEqual(max(nices), 5, nices)

    def test_spans_of_a_row_do_not_overlap(self):
        rows = {}
        for event in self.trace["traceEvents"]:
            if event["ph"] == "X":
                rows.setdefault((event["pid"], event["tid"]), []).append((event["ts"], event["ts"] + event["dur"]))
        self.assertEqual(len([row for row in rows if row[0] != 1]), SLAVES * (THREADS + 2),
                         "one row for each render thread, one for the builder, and one for transfers")
        for row, spans in rows.items():
            spans.sort()
            for one, next_ in zip(spans, spans[1:]):
                self.assertLessEqual(one[1], next_[0] + 0.002, f"row {row}")  # two roundings to a nanosecond

    def test_tiles_lie_within_their_frames_and_leases(self):
        events = self.trace["traceEvents"]
        errors = {int(pid): error for pid, error in self.trace["otherData"]["clock_error_us"].items()}
        self.assertEqual(len(errors), SLAVES)
        frames = {e["args"]["frame"]: e for e in events if e["ph"] == "X" and e["pid"] == 1}
        spans = [e for e in events if e["ph"] == "X" and e["pid"] != 1]
        tiles = [span for span in spans if "frame" in span["args"]]
        builds = [span for span in spans if "built_primitives" in span["args"]]
        transfers = [span for span in spans if "frame" not in span["args"] and span not in builds]
        for of_scenes in (builds, transfers):
            self.assertEqual([span["args"]["scene_version"] for span in of_scenes], [1] * SLAVES)
        for build in builds:
            ends = [span["ts"] + span["dur"] for span in transfers if span["pid"] == build["pid"]]
            self.assertEqual([round(end) for end in ends], [round(build["ts"])], "its transfer ends where it begins")
        self.assertEqual(len(frames), FRAMES)
        # Late tiles are leased twice; the second answer is traced, too.
        self.assertEqual(len([tile for tile in tiles if tile["args"]["accepted"]]), FRAMES * 10 * 8)
        for tile in tiles:
            frame, error = frames[tile["args"]["frame"]], errors[tile["pid"]]
            self.assertGreaterEqual(tile["ts"], frame["ts"] - error, tile)
            self.assertLessEqual(tile["ts"] + tile["dur"], frame["ts"] + frame["dur"] + error, tile)
            self.assertGreaterEqual(tile["args"]["waited_us"], -error, "begun before it was leased")
            self.assertGreaterEqual(tile["args"]["returned_us"], -error, "received before it was rendered")
        for end in ("b", "e"):
            ids = [e["id"] for e in events if e["ph"] == end]
            self.assertEqual(len(ids), len(set(ids)))
            self.assertEqual(len(ids), len(tiles))

    def test_the_script_draws_it(self):
        svg = self.cluster.folder / "trace.svg"
        subprocess.run([sys.executable, str(DEPLOY / "trace_svg.py"), str(self.trace_path), "-o", str(svg)], check=True, timeout=cluster_lib.PATIENCE_S)
        text = svg.read_text()
        self.assertIn(f"{SLAVES} slaves, render threads busy", text)
        self.assertGreaterEqual(text.count("<rect"), FRAMES * 10 * 8)

    def test_the_dashboard_asks_for_what_there_is(self):
        there = {re.sub(r"\{.*", "", name) for page in (self.page, self.slave_page) for name in samples_of(page)}
        dashboard = json.loads((DEPLOY / "metrics" / "grafana-dashboard.json").read_text())
        asked = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
        asked += re.findall(r"expr: (.*)", (DEPLOY / "metrics" / "prometheus.yml").read_text())
        self.assertGreater(len(asked), 20)
        for expression in asked:
            bare = re.sub(r'"[^"]*"', "", expression)
            names = {word for word in re.findall(r"[a-zA-Z_:][a-zA-Z0-9_:]*", re.sub(r"\[\w+\]|\b\d[\w.]*", "", bare))} - PROMQL
            self.assertTrue(names, expression)
            self.assertLessEqual(names, there, expression)


if __name__ == "__main__":
    unittest.main(verbosity=2)
