# SPDX-License-Identifier: Apache-2.0
"""Writes small OBJ files with MTL, and PLY files: the dome of gltf_file.py, in OBJ with a lamp that is a triangle."""
from gltf_file import dome

CAMERA = "0,0,4 0,0,0 0,1,0 34.4"


class ObjFile:
    """`material` holds the lines of the dome's material; `lines` those of the OBJ file after its vertices."""

    def __init__(self):
        self.positions, self.normals, self.uvs, self.triangles = dome()
        self.colors, self.files, self.has_normals = None, {}, True
        self.material = ["Kd .5 .5 .5"]
        self.lines = None
        self.more = []

    def map(self, key, picture, options=""):
        """Adds a line to the material that names a picture."""
        name = f"{key}.png"
        self.files[name] = picture
        self.material.append(" ".join(word for word in (key, options, name) if word))

    def faces(self):
        def corner(i):
            return f"{i + 1}/{i + 1}" + (f"/{i + 1}" if self.has_normals else "")
        return ["f " + " ".join(corner(i) for i in t) for t in self.triangles]

    def write(self, path):
        for name, data in self.files.items():
            path.parent.joinpath(name).write_bytes(data)
        count = len(self.positions)
        text = ["mtllib scene.mtl"]
        for i, p in enumerate(self.positions):
            text.append("v %g %g %g" % p + (" %g %g %g" % self.colors[i] if self.colors else ""))
        text += ["vn %g %g %g" % n for n in self.normals] + ["vt %g %g" % (u, 1 - v) for u, v in self.uvs]
        text += ["usemtl dome"] + (self.faces() if self.lines is None else self.lines) + self.more
        text += ["v 1.5 2.5 4", "v 2.5 1.5 4", "v 2.5 2.5 3.6", "usemtl lamp", "f -1 -2 -3", "f -3 -2 -1"]
        path.write_text("\n".join(text) + "\n")
        materials = ["newmtl dome", *self.material, "newmtl lamp", "Kd 0 0 0", "Ke 60 60 60"]
        path.with_suffix(".mtl").write_text("\n".join(materials) + "\n")
        assert count > 0


class PlyFile:
    def __init__(self):
        self.positions, self.normals, _, self.triangles = dome()
        self.columns = ["property float x", "property float y", "property float z"]
        self.rows = [list(p) for p in self.positions]
        self.faces = [list(t) for t in self.triangles]
        self.head = []  # further elements, with their lines
        self.tail = []

    def column(self, line, values):
        """Adds a property to the vertices."""
        self.columns.append(line)
        for row, value in zip(self.rows, values):
            row.append(value)

    def write(self, path):
        text = ["ply", "format ascii 1.0", f"element vertex {len(self.rows)}", *self.columns,
                f"element face {len(self.faces)}", "property list uchar int vertex_indices", *self.head, "end_header"]
        text += [" ".join("%g" % x for x in row) for row in self.rows]
        text += [" ".join(map(str, [len(f), *f])) for f in self.faces] + self.tail
        path.write_text("\n".join(text) + "\n")
