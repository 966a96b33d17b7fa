# SPDX-License-Identifier: Apache-2.0
"""Generates a chart of materials: metals by roughness, skin tones, plastics and glass on a grey
floor. What a light, a tone curve or a BSDF does wrong shows here first."""
import math
import pathlib

# Linear RGB. Metals: reflectance at normal incidence of gold, copper, silver, aluminium, iron.
METALS = [(1.00, 0.77, 0.34), (0.95, 0.64, 0.54), (0.97, 0.96, 0.92), (0.91, 0.92, 0.92),
          (0.56, 0.57, 0.58)]
# Six tones from light to dark, spaced evenly in lightness.
SKINS = [(0.72, 0.49, 0.38), (0.58, 0.35, 0.25), (0.42, 0.23, 0.15), (0.28, 0.14, 0.084),
         (0.15, 0.072, 0.042), (0.062, 0.029, 0.018)]
PLASTICS = [(0.6, 0.04, 0.03), (0.03, 0.25, 0.06), (0.02, 0.07, 0.45), (0.75, 0.75, 0.75),
            (0.18, 0.18, 0.18), (0.02, 0.02, 0.02)]


def sphere(lines, count, centre, radius, material, around=48):
    rows = around // 2
    lines.append(f"usemtl {material}")
    for i in range(rows + 1):
        for j in range(around):
            theta, phi = math.pi * i / rows, 2 * math.pi * j / around
            n = (math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi))
            lines.append("v " + " ".join(f"{c + radius * k:.6f}" for c, k in zip(centre, n)))
            lines.append("vn " + " ".join(f"{k:.6f}" for k in n))
    for i in range(rows):
        for j in range(around):
            a, b = count + i * around + j + 1, count + i * around + (j + 1) % around + 1
            corners = ([a, b + around, a + around] if i == 0 else
                       [a, b, a + around] if i == rows - 1 else [a, b, b + around, a + around])
            lines.append("f " + " ".join(f"{k}//{k}" for k in corners))
    return count + (rows + 1) * around


def rows_of_materials():
    rough = [0.05, 0.2, 0.35, 0.5, 0.7]
    metals = [(f"metal{i}", f"Kd {r} {g} {b}\nPm 1\nPr {rough[i]}")
              for i, (r, g, b) in enumerate(METALS)]
    metals.append(("chrome", "Ks 0.95 0.95 0.95\nKd 0 0 0\nillum 3"))
    skins = [(f"skin{i}", f"Kd {r} {g} {b}\nPr 0.5\nPm 0") for i, (r, g, b) in enumerate(SKINS)]
    plastics = [(f"plastic{i}", f"Kd {r} {g} {b}\nPr {0.1 + 0.12 * i:.2f}\nPm 0")
                for i, (r, g, b) in enumerate(PLASTICS)]
    glasses = [(f"glass{i}", f"Kd 0 0 0\nNi {ior}\nTf {t}\nd 0.1\nillum 7")
               for i, (ior, t) in enumerate([(1.33, "1 1 1"), (1.5, "1 1 1"), (1.8, "1 1 1"),
                                             (2.4, "1 1 1"), (1.5, "0.5 0.9 0.6"),
                                             (1.5, "0.95 0.6 0.4")])]
    return [glasses, metals, plastics, skins]


def write(folder):
    """Writes the chart. Returns: the path of the OBJ file."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    lines, count, materials = ["mtllib chart.mtl"], 0, ["newmtl floor\nKd 0.45 0.45 0.45"]
    for row, row_materials in enumerate(rows_of_materials()):
        for column, (name, text) in enumerate(row_materials):
            materials.append(f"newmtl {name}\n{text}")
            count = sphere(lines, count, (1.15 * (column - 2.5), 0.5, 1.25 * (row - 1.5)), 0.5, name)
    lines += ["usemtl floor"] + ["v %g 0 %g" % corner for corner in
                                 ((-4.2, -3), (-4.2, 3), (4.2, 3), (4.2, -3))] + ["f -4 -3 -2 -1"]
    (folder / "chart.mtl").write_text("\n".join(materials) + "\n")
    path = folder / "chart.obj"
    path.write_text("\n".join(lines) + "\n")
    return str(path)
