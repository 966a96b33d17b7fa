#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every wrong input gets one line on stderr that says what is wrong, and exit code 1 or 2."""
import os
import pathlib
import resource
import shutil
import signal
import socket
import subprocess
import sys
import unittest

import cluster_lib

QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

# Command line (after 'render'; scene, --size and -o are added where absent), exit code, words of the error line.
USAGE = [
    ("--nonsense", 2, ["--nonsense"]),
    ("--siez 64x64", 2, ["'--siez'", "did you mean '--size'?"]),
    ("--enviroment=constant:1,1,1", 2, ["'--enviroment'", "did you mean '--environment'?"]),
    ("--renderer ptah", 2, ["ptah", "did you mean 'path'?"]),
    ("--config typo.toml", 2, ["typo.toml:1", "did you mean 'passes'?"]),
    ("builtin:cornel", 2, ["cornel", "did you mean 'cornell'?"]),
    ("--size 0x0", 2, ["--size", "0x0"]),
    ("--size 99999x99999", 2, ["--size", "16384"]),
    ("--size 640", 2, ["--size"]),
    ("--size 10x10x10", 2, ["--size"]),
    ("--frames 5:2", 2, ["--frames", "5:2"]),
    ("--frames 1", 2, ["--frames"]),
    ("--tile 0", 2, ["--tile"]),
    ("--tile 1e9", 2, ["--tile"]),
    ("--threads 0", 2, ["--threads"]),
    ("--renderer nonsense", 2, ["nonsense"]),
    ("--pixels nonsense", 2, ["nonsense"]),
    ("--isa nonsense", 2, ["nonsense"]),
    ("--aa 0", 2, ["--aa"]),
    ("--fps 0", 2, ["--fps"]),
    ("--fps nan", 2, ["--fps"]),
    ("--wait -1", 2, ["--wait"]),
    ("--frames-in-flight 3", 2, ["--frames-in-flight"]),
    ("--log-level loud", 2, ["loud"]),
    ("--log-format xml", 2, ["xml"]),
    ("--listen nowhere", 2, ["nowhere"]),
    ("--listen 127.0.0.1:99999", 2, ["99999"]),
    ("--slaves 3", 2, ["--slaves"]),
    ("--local -1", 2, ["--local"]),
    ("--local 0", 2, ["--local 0", "--listen"]),
    ("--listen 127.0.0.1:0", 2, ["--keys"]),
    ("--connect 127.0.0.1:1", 2, ["tessera-keys"]),
    ("--config small.toml", 2, ["small.toml", "--size"]),
    ("--plain --keys x", 2, ["--plain"]),
    ("--connect 127.0.0.1:1 --listen 127.0.0.1:2", 2, ["--connect"]),
    ("--config missing.toml", 2, ["missing.toml"]),
    ("--config broken.toml", 2, ["broken.toml"]),
    ("--config unknown.toml", 2, ["unknown.toml", "colour"]),
    ("--camera missing.camera", 1, ["missing.camera"]),
    ("--camera unknown.camera", 1, ["unknown.camera", "2"]),
    ("--camera 1,2,3", 2, ["camera"]),
    ("--camera=0,0,0 0,0,0 0,1,0 45", 2, ["camera"]),
    ("--camera=0,0,0 0,2,0 0,1,0 45", 2, ["camera"]),
    ("--camera=0,0,nan 0,2,0 0,0,1 45", 2, ["camera"]),
    ("-o out.tga", 2, ["out.tga"]),
    ("-o out", 2, ["out"]),
    ("-o no-such-folder/out.png", 1, ["no-such-folder"]),
    ("-o out.png --frames 0:1", 2, ["%04d"]),
    ("-o out-%s.png", 2, ["%"]),
    ("-o out-%04d-%04d.png --frames 0:1", 2, ["%"]),
    ("--stats no-such-folder/s.jsonl", 1, ["no-such-folder"]),
    ("--environment nonsense", 2, ["nonsense", ".hdr", "constant:"]),
    ("--environment constant:1,1", 2, ["constant:1,1"]),
    ("--environment missing.hdr", 1, ["missing.hdr"]),
    ("--environment empty.hdr", 1, ["empty.hdr", "empty"]),
    ("--environment malformed.hdr", 1, ["malformed.hdr"]),
    ("--environment malformed.exr", 1, ["malformed.exr"]),
    ("builtin:nonsense", 2, ["nonsense"]),
    ("missing.obj", 1, ["missing.obj"]),
    ("folder.obj", 1, ["folder.obj"]),
    ("scene.xyz", 2, ["scene.xyz"]),
    ("empty.obj", 1, ["empty.obj"]),
    ("empty.ply", 1, ["empty.ply"]),
    ("empty.glb", 1, ["empty.glb"]),
    ("malformed.obj", 1, ["malformed.obj"]),
    ("malformed.ply", 1, ["malformed.ply"]),
    ("malformed.gltf", 1, ["malformed.gltf"]),
    ("huge.ply", 1, ["huge.ply"]),
    ("range.obj", 1, ["range.obj"]),
    ("range.ply", 1, ["range.ply"]),
    ("nan.obj", 1, ["nan.obj"]),
    ("garbage.glb", 1, ["garbage.glb"]),
    ("/dev/zero", 2, ["/dev/zero", ".obj"]),
    ("pipe.obj", 1, ["pipe.obj"]),
]
OTHERS = [
    ("tessera-master", "", 2, []),
    ("tessera-master", "nonsense", 2, []),
    ("tessera-master", "rendr a.obj", 2, ["'rendr'", "did you mean 'render'?"]),
    ("tessera-master", "serve --metric 127.0.0.1:0", 2, ["'--metric'", "did you mean '--metrics'?", "serve --help"]),
    ("tessera-slave", "--mastre 127.0.0.1:7400", 2, ["'--mastre'", "did you mean '--master'?"]),
    ("tessera-keys", "add x slave y --day 3", 2, ["'--day'", "did you mean '--days'?"]),
    ("tessera-keys", "renw x y", 2, ["'renw'", "did you mean 'renew'?"]),
    ("tessera-import", "x.obj --memory 3", 2, ["'--memory'", "did you mean '--memory-mb'?"]),
    ("tessera-trace", "a.obj b c --bundel 4", 2, ["'--bundel'", "did you mean '--bundle'?"]),
    ("tessera-sim", "--sede 3", 2, ["'--sede'", "did you mean '--seed'?"]),
    ("tessera-sim", "predict slavs=3", 2, ["'slavs'", "did you mean 'slaves'?"]),
    ("tessera-bench", "--quik", 2, ["'--quik'", "did you mean '--quick'?"]),
    ("tessera-master", "render", 2, []),
    ("tessera-master", "serve --listen 0.0.0.0:0", 2, ["tessera-keys"]),
    ("tessera-master", "serve --listen 0.0.0.0:7400 --plain", 2, ["loopback"]),
    ("tessera-master", "serve --listen 127.0.0.1:7400 --keys no-such-folder", 1, ["no-such-folder"]),
    ("tessera-master", "serve --nonsense", 2, ["--nonsense", "serve --help"]),
    ("tessera-master", "status --connect 127.0.0.1:1", 2, ["tessera-keys"]),
    ("tessera-master", "status --connect 127.0.0.1:1 --plain", 1, ["127.0.0.1:1"]),
    ("tessera-slave", "", 2, ["--master"]),
    ("tessera-slave", "--master 127.0.0.1:7400", 2, ["--keys"]),
    ("tessera-slave", "--master 10.0.0.1:7400 --plain", 2, ["loopback"]),
    ("tessera-slave", "--master nowhere --plain", 2, ["nowhere"]),
    ("tessera-slave", "--master 127.0.0.1:7400 --plain --threads 0", 2, ["--threads"]),
    ("tessera-slave", "--master 127.0.0.1:7400 --plain --isa nonsense", 2, ["nonsense"]),
    ("tessera-slave", "--master 127.0.0.1:7400 --keys no-such-folder", 1, ["no-such-folder"]),
    ("tessera-keys", "", 2, []),
    ("tessera-keys", "nonsense", 2, []),
    ("tessera-keys", "add no-such-folder slave x", 1, ["no-such-folder"]),
]


def write_files(folder):
    texts = {
        "scene.xyz": "x", "empty.obj": "", "empty.ply": "", "empty.glb": "", "empty.hdr": "",
        "malformed.hdr": "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\nx", "malformed.exr": "x",
        "malformed.obj": QUAD + "f 1 2\nf x y z\n",
        "range.obj": QUAD + "f 1 2 9\n",
        "nan.obj": QUAD.replace("1 1 0", "nan 1 0") + "f 1 2 3\n",
        "malformed.gltf": '{"asset": {"version": "2.0"}, "meshes": [',
        "broken.toml": "size = \n", "unknown.toml": 'colour = "blue"\n', "typo.toml": 'pases = 3\n',
        "small.toml": 'size = "0x0"\n', "unknown.camera": "eye 0 0 5\nlens 3\n",
        "good.obj": QUAD + "f 1 2 3 4\n",
        "no-material.obj": "mtllib gone.mtl\n" + QUAD + "usemtl red\nf 1 2 3 4\n",
        "no-texture.obj": "mtllib textured.mtl\n" + QUAD + "usemtl red\nf 1 2 3 4\n",
        "textured.mtl": "newmtl red\nKd 1 0 0\nmap_Kd gone.png\n",
    }
    head = "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n" \
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    texts["malformed.ply"] = head.format(3) + "0 0 0\n1 0"
    texts["huge.ply"] = head.format(4294967295) + "0 0 0\n"
    texts["range.ply"] = head.format(3) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"
    for name, text in texts.items():
        (folder / name).write_text(text)
    (folder / "garbage.glb").write_bytes(b"glTF\x02\0\0\0\xff\xff\xff\xff" + bytes(range(256)))
    (folder / "folder.obj").mkdir()
    os.mkfifo(folder / "pipe.obj")


class WrongInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cluster_lib.Cluster()
        cls.cluster.__enter__()
        cls.addClassCleanup(cls.cluster.__exit__, None, None, None)
        cls.folder = cls.cluster.folder / "input"
        cls.folder.mkdir()
        write_files(cls.folder)

    def run_program(self, name, words, **more):
        return subprocess.run([cluster_lib.program(name), *words], cwd=self.folder, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, errors="replace", timeout=cluster_lib.PATIENCE_S, **more)

    def expect(self, name, words, code, said, **more):
        before = sorted(os.listdir(self.folder))
        run = self.run_program(name, words, **more)
        print(f"{run.returncode}  {name} {' '.join(words)}\n   {run.stderr.strip()}")
        self.assertEqual(run.returncode, code, run.stderr)
        self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
        for word in said:
            self.assertIn(word, run.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), before, "a file is left behind")

    @staticmethod
    def words_of(line):
        if line.startswith("--camera="):
            return [line]
        words = line.split()
        scene = [] if words[0][0] != "-" else ["builtin:cornell"]
        output = [] if "-o" in words else ["-o", "out.png"]
        size = [] if "--size" in words or "small.toml" in words else ["--size", "16x16"]
        return [*scene, *size, *words, *output]

    def test_the_command_line_of_render(self):
        for line, code, said in USAGE:
            with self.subTest(line):
                words = self.words_of(line)
                if line.startswith("--camera="):
                    words = ["builtin:cornell", "-o", "out.png", *words]
                self.expect("tessera-master", ["render", "--quiet", *words], code, said)

    def test_other_programs(self):
        for name, line, code, said in OTHERS:
            with self.subTest(f"{name} {line}"):
                self.expect(name, line.split(), code, said)

    def test_help_and_version(self):
        for name in ("tessera-master", "tessera-slave", "tessera-keys", "tessera-import"):
            for word in ("--help", "--version"):
                with self.subTest(f"{name} {word}"):
                    run = self.run_program(name, [word])
                    self.assertEqual((run.returncode, run.stderr), (0, ""))
                    self.assertIn("tessera", run.stdout.lower())

    def test_what_is_only_worth_a_warning(self):
        for scene, word in (("no-material.obj", "gone.mtl"), ("no-texture.obj", "gone.png")):
            with self.subTest(scene):
                run = self.run_program("tessera-master", ["render", scene, "--size", "16x16", "-o", "warned.png", "--quiet"])
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertIn(word, run.stderr)
                (self.folder / "warned.png").unlink()

    def test_no_name_of_a_file_moves_the_cursor(self):
        for number, name in enumerate(("\x1b[2Jgone", "\x1b]0;title\x07", "a\u009b31mb", "a\x9b31mb", "\u202egnp")):
            with self.subTest(repr(name)):
                path = self.folder / f"escape{number}.obj"
                path.write_bytes(f"mtllib {name}.mtl\n".encode("latin-1" if "\x9b" in name and number == 3 else "utf-8") +
                                 (QUAD + f"usemtl {name}\nf 1 2 3 4\n").encode())
                run = subprocess.run([cluster_lib.program("tessera-master"), "render", path.name, "--size", "16x16", "-o",
                                      "escape.png"], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True,
                                     timeout=cluster_lib.PATIENCE_S)
                self.assertEqual(run.returncode, 0, run.stderr)
                self.assertIn(b".mtl", run.stderr)
                told = run.stderr.decode()  # strictly: what is no UTF-8 raises
                self.assertFalse([c for c in told if c != "\n" and (not c.isprintable() or 0x80 <= ord(c) < 0xa0)], told)
                (self.folder / "escape.png").unlink()
                path.unlink()

    def test_a_scene_that_may_not_be_read(self):
        path = self.folder / "secret.obj"
        path.write_text(QUAD)
        path.chmod(0)
        try:
            if os.access(path, os.R_OK):
                self.skipTest("root reads everything")
            self.expect("tessera-master", ["render", "--quiet", path.name, "-o", "out.png"], 1, ["secret.obj"])
        finally:
            path.unlink()

    def test_a_full_disk_names_file_and_reason_and_leaves_no_half_file(self):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # so that write() fails, as it does on a full disk
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
        self.expect("tessera-master", ["render", "--quiet", "builtin:cornell", "--size", "400x400", "-o", "big.pfm"], 1,
                    ["big.pfm"], preexec_fn=limit)

    def test_a_port_in_use(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            address = f"127.0.0.1:{taken.getsockname()[1]}"
            self.expect("tessera-master", ["serve", "--listen", address, "--keys", str(self.cluster.keys / "master")], 1, [address])

    def test_a_name_that_does_not_resolve(self):
        self.expect("tessera-master", ["render", "--quiet", "builtin:cornell", "-o", "out.png", "--connect",
                                       "no-such-host.invalid:7400", "--keys", str(self.cluster.keys / "app")], 1, ["no-such-host.invalid"])

    def test_no_slave_comes(self):
        self.expect("tessera-master", ["render", "--quiet", "builtin:cornell", "-o", "out.png", "--listen", "127.0.0.1:0",
                                       "--keys", str(self.cluster.keys / "master"), "--slaves", "1", "--wait", "1"], 1, ["slave"])

    def test_a_key_that_others_may_read(self):
        folder = self.cluster.keys.parent / "loose"
        shutil.copytree(self.cluster.keys / "app", folder)
        (folder / "node.key").chmod(0o644)
        self.expect("tessera-master", ["status", "--connect", "127.0.0.1:1", "--keys", str(folder)], 1, ["node.key"])

    def test_a_certificate_that_has_expired(self):
        self.cluster.make_keys("add", str(self.cluster.keys), "app", "old", "--days", "-1")
        self.expect("tessera-master", ["status", "--connect", "127.0.0.1:1", "--keys", str(self.cluster.keys / "old")], 1, ["expired"])

    def test_no_display(self):
        environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        # The missing display is found before the scene is read, which may take minutes.
        for scene in ("builtin:cornell", "missing.obj", "malformed.gltf"):
            self.expect("tessera-master", ["view", "--quiet", scene], 1, ["no display"], env=environment)


class WrongPeers(unittest.TestCase):
    def setUp(self):
        self.cluster = cluster_lib.Cluster()
        self.cluster.__enter__()
        self.addCleanup(self.cluster.__exit__, None, None, None)

    def log(self, name):
        path = pathlib.Path(self.cluster.folder, f"{name}.log")
        return path.read_text(errors="replace") if path.exists() else ""

    def test_a_slave_waits_for_its_master_and_says_so(self):
        self.cluster.port = cluster_lib.free_port()
        slave = self.cluster.slave("early")
        cluster_lib.wait_until("a line about waiting", lambda: self.cluster.address in self.log("early"))
        self.assertIsNone(slave.poll())
        self.cluster.start("master", [cluster_lib.program("tessera-master"), "serve", "--listen", self.cluster.address,
                                      "--keys", str(self.cluster.keys / "master")])
        self.cluster.wait_for_slaves(1)

    def test_a_slave_survives_its_master(self):
        master = self.cluster.serve()
        self.cluster.slaves(1)
        before = self.cluster.render("builtin:cornell", "--size", "64x64").digests
        master.kill()
        master.wait()
        self.cluster.start("master-again", [cluster_lib.program("tessera-master"), "serve", "--listen", self.cluster.address,
                                            "--keys", str(self.cluster.keys / "master")])
        self.cluster.wait_for_slaves(1)
        self.assertEqual(self.cluster.render("builtin:cornell", "--size", "64x64").digests, before)

    def test_keys_of_the_wrong_role_are_refused(self):
        self.cluster.serve()
        slave = self.cluster.start("wrong-role", [cluster_lib.program("tessera-slave"), "--master", self.cluster.address,
                                                  "--name", "wrong", "--keys", str(self.cluster.keys / "app")])
        self.assertEqual(slave.wait(cluster_lib.PATIENCE_S), 1)
        self.assertIn("role", self.log("wrong-role"))
        del self.cluster.processes["wrong-role"]
        self.assertEqual(self.cluster.status()["slaves"], [])

    def test_keys_of_another_cluster_are_refused(self):
        self.cluster.serve()
        with cluster_lib.Cluster() as other:
            self.cluster.start("stranger", [cluster_lib.program("tessera-slave"), "--master", self.cluster.address, "--name",
                                            "stranger", "--keys", other.add_key("slave", "stranger")])
            self.assertIn("certificate", self.cluster.wait_for_refusal("stranger"))
            self.assertEqual(self.cluster.status()["slaves"], [])

    def test_a_certificate_serves_one_slave(self):
        self.cluster.serve()
        self.cluster.slaves(1)
        self.cluster.start("twin", [cluster_lib.program("tessera-slave"), "--master", self.cluster.address, "--keys",
                                    str(self.cluster.keys / "slave-1"), "--name", "other"])
        self.assertIn("certificate 'slave-1'", self.cluster.wait_for_refusal("twin"))
        self.assertEqual(len(self.cluster.status()["slaves"]), 1)

    def test_without_a_name_a_slave_has_its_certificates(self):
        self.cluster.serve()
        self.cluster.start("anonymous", [cluster_lib.program("tessera-slave"), "--master", self.cluster.address, "--keys",
                                         self.cluster.add_key("slave", "bert")])
        self.cluster.wait_for_slaves(1)
        self.assertIsNotNone(self.cluster.slave_status("bert"))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
