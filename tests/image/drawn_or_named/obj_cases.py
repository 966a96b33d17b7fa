# SPDX-License-Identifier: Apache-2.0
"""The cases of every key of OBJ, MTL (with its PBR keys) and PLY."""
from core_cases import BUMPS, GREY_WHITE, RED_BLUE
from expectations import LEFT, RIGHT, both, brighter, case_of, colour, darker, differs, same
from gltf_file import SIDE, halves

RED = ["Kd .8 .05 .05"]
obj = case_of(".obj")
ply = case_of(".ply")


def lines(*text):
    """Returns a change that gives the dome a material of these lines."""
    return lambda f: setattr(f, "material", list(text))


def mapped(key, picture, *text, options=""):
    def change(f):
        f.material = list(text) if text else f.material
        f.map(key, picture, options)
    return change


def then(*changes):
    def change(f):
        for one in changes:
            one(f)
    return change


def again(name):
    return lambda f: f.more.append(name)


SHINY = ("Kd .3 .3 .3", "Ks .8 .8 .8", "Ns 60", "illum 2")
METAL = ("Kd .9 .6 .3", "Pr .4", "Pm 1")
GLASS = ("Kd 0 0 0", "illum 7", "Ni 1.5")

# MTL: colours
obj.drawn("Kd", lines(*RED), colour(0, 1.3))
obj.drawn("Kd xyz", lines("Kd xyz .2 .1 .05"), differs(.05))
obj.named("Kd spectral", lines("Kd spectral file.rfl"), "spectral' needs a file of spectra")
obj.drawn("Ke", lines("Kd .5 .5 .5", "Ke .5 .5 .5"), brighter(1.2))
obj.drawn("Ks", lines(*SHINY), differs(.05), base=lines("Kd .3 .3 .3"))
obj.drawn("Ns", lines("Kd .3 .3 .3", "Ks .8 .8 .8", "Ns 2", "illum 2"), differs(.05), base=lines(*SHINY))
obj.named("Ka", lines("Kd .5 .5 .5", "Ka .2 .2 .2"), "not drawn: Ka (ambient light) 1x")
obj.silent("Ka 0", lines("Kd .5 .5 .5", "Ka 0 0 0"), "no light")
obj.drawn("Tf", lines(*GLASS, "Tf .9 .1 .1"), colour(0, 1.3), base=lines(*GLASS))
obj.drawn("Ni", lines("Kd 0 0 0", "illum 7", "Ni 2.4"), differs(.02), base=lines(*GLASS))
obj.drawn("d", lines("Kd .5 .5 .5", "d .3"), darker())
obj.drawn("Tr", lines("Kd .5 .5 .5", "Tr .7"), same(.001), base=lines("Kd .5 .5 .5", "d .3"))
obj.named("d and Tr", lines("Kd .5 .5 .5", "d .3", "Tr .1"), "contradict each other")
obj.named("d -halo", lines("Kd .5 .5 .5", "d -halo .3"), "taken for plain 'd'")
obj.named("sharpness", lines("Kd .5 .5 .5", "sharpness 60"), "not drawn: sharpness")
obj.named("(unknown key)", lines("Kd .5 .5 .5", "Kq 3"), "'Kq' is not understood")

# MTL: illum
obj.drawn("illum 0", lines(*SHINY[:3], "illum 0"), same(.001), base=lines("Kd .3 .3 .3"))
obj.drawn("illum 1", lines(*SHINY[:3], "illum 1"), same(.001), base=lines("Kd .3 .3 .3"))
obj.drawn("illum 2", lines(*SHINY), differs(.05), base=lines("Kd .3 .3 .3"))
obj.drawn("illum 3", lines("Kd 0 0 0", "Ks .9 .9 .9", "illum 3"), differs(.05), base=lines("Kd 0 0 0"))
obj.drawn("illum 4", lines("Kd .5 .5 .5", "illum 4"), differs(.05))
obj.drawn("illum 5", lines("Kd 0 0 0", "Ks .9 .9 .9", "illum 5"), differs(.05), base=lines("Kd 0 0 0"))
obj.drawn("illum 6", lines("Kd 0 0 0", "illum 6", "Ni 1.5"), same(.001), base=lines(*GLASS))
obj.drawn("illum 7", lines(*GLASS), differs(.05), base=lines("Kd 0 0 0"))
obj.drawn("illum 8", lines(*SHINY[:3], "illum 8"), same(.001), base=lines(*SHINY))
obj.drawn("illum 9", lines("Kd .5 .5 .5", "illum 9"), same(.001), base=lines("Kd .5 .5 .5", "illum 4"))
obj.named("illum 12", lines("Kd .5 .5 .5", "illum 12"), "'illum 12' is not understood")

# MTL: pictures
obj.drawn("map_Kd", mapped("map_Kd", RED_BLUE, "Kd 1 1 1"), both(colour(0, part=LEFT), colour(2, part=RIGHT)))
obj.named("map_Kd (missing)", lines("Kd 1 1 1", "map_Kd gone.png"), "gone.png")
obj.named("map_Kd with alpha", mapped("map_Kd", halves((9, 9, 9, 0), (9, 9, 9, 255), alpha=True), "Kd 1 1 1"), "has an alpha channel")
obj.drawn("map_Ks", mapped("map_Ks", RED_BLUE, *SHINY), differs(.01), base=lines(*SHINY))
obj.drawn("map_Ke", mapped("map_Ke", RED_BLUE, "Kd .5 .5 .5"), colour(0, part=LEFT))
obj.drawn("map_Ns", mapped("map_Ns", halves((4,) * 3, (255,) * 3), *SHINY), differs(.01), base=lines(*SHINY))
obj.drawn("map_d", mapped("map_d", halves((0, 0, 0), (255, 255, 255)), "Kd .5 .5 .5"), darker(part=LEFT))
obj.named("map_Ka", mapped("map_Ka", RED_BLUE, "Kd .5 .5 .5"), "not drawn: map_Ka (ambient light)")
obj.drawn("bump", mapped("bump", BUMPS, "Kd .5 .5 .5"), differs(.002))
obj.drawn("map_Bump", mapped("map_Bump", BUMPS, "Kd .5 .5 .5"), same(0), base=mapped("bump", BUMPS, "Kd .5 .5 .5"))
obj.drawn("bump -bm", mapped("bump", BUMPS, "Kd .5 .5 .5", options="-bm 5"), differs(.005),
          base=mapped("bump", BUMPS, "Kd .5 .5 .5"))
obj.drawn("norm", mapped("norm", BUMPS, "Kd .5 .5 .5"), differs(.005))
obj.named("norm and bump", then(mapped("norm", BUMPS, "Kd .5 .5 .5"), mapped("bump", BUMPS)), "'norm' is drawn")
for key in ["disp", "decal", "refl", "map_aat on"]:
    obj.named(key, mapped(key, GREY_WHITE, "Kd .5 .5 .5") if " " not in key else lines("Kd .5 .5 .5", key), "not drawn: " + key.split()[0])
obj.drawn("-o", mapped("map_Kd", RED_BLUE, "Kd 1 1 1", options="-o .5"), both(colour(2, part=LEFT), colour(0, part=RIGHT)),
          base=mapped("map_Kd", RED_BLUE, "Kd 1 1 1"))
obj.drawn("-s", mapped("map_Kd", RED_BLUE, "Kd 1 1 1", options="-s .5 1"), colour(0, part=RIGHT), base=mapped("map_Kd", RED_BLUE, "Kd 1 1 1"))
obj.drawn("-mm", mapped("map_Kd", RED_BLUE, "Kd 1 1 1", options="-mm .2 .5"), differs(.05), base=mapped("map_Kd", RED_BLUE, "Kd 1 1 1"))
obj.drawn("-clamp", mapped("map_Kd", RED_BLUE, "Kd 1 1 1", options="-s 2 2 -clamp on"), differs(.01),
          base=mapped("map_Kd", RED_BLUE, "Kd 1 1 1", options="-s 2 2"))
obj.named("-t", mapped("map_Kd", RED_BLUE, "Kd 1 1 1", options="-t .1 .1 .1"), "-t")
obj.silent("-blendu, -blendv", mapped("map_Kd", RED_BLUE, "Kd 1 1 1", options="-blendu on -blendv on"), "as it is without",
           base=mapped("map_Kd", RED_BLUE, "Kd 1 1 1"))
obj.named("-cc", mapped("map_Kd", RED_BLUE, "Kd 1 1 1", options="-cc on"), "-cc")

# MTL: physically based keys
obj.drawn("Pr", lines("Kd .9 .6 .3", "Pr .9", "Pm 1"), differs(.05), base=lines(*METAL))
obj.drawn("Pm", lines(*METAL), differs(.05), base=lines("Kd .9 .6 .3", "Pr .4"))
obj.drawn("map_Pr", mapped("map_Pr", halves((20,) * 3, (255,) * 3), "Kd .9 .6 .3", "Pr 1", "Pm 1"), differs(.02),
          base=lines("Kd .9 .6 .3", "Pr 1", "Pm 1"))
obj.drawn("map_Pm", mapped("map_Pm", halves((0,) * 3, (255,) * 3), *METAL), differs(.02), base=lines(*METAL))
obj.drawn("Ps", lines("Kd .1 .1 .3", "Pr 1", "Ps 1"), differs(.005), base=lines("Kd .1 .1 .3", "Pr 1"))
obj.drawn("map_Ps", mapped("map_Ps", RED_BLUE, "Kd .1 .1 .1", "Pr 1"), differs(.005), base=lines("Kd .1 .1 .1", "Pr 1"))
obj.drawn("Pc", lines("Kd .5 .5 .5", "Pr 1", "Pc 1"), differs(.01), base=lines("Kd .5 .5 .5", "Pr 1"))
obj.drawn("Pcr", lines("Kd .5 .5 .5", "Pr 1", "Pc 1", "Pcr .6"), differs(.002), base=lines("Kd .5 .5 .5", "Pr 1", "Pc 1"))
obj.drawn("aniso", lines(*METAL, "aniso 1"), differs(.02), base=lines(*METAL))
obj.drawn("anisor", lines(*METAL, "aniso 1", "anisor .25"), differs(.02), base=lines(*METAL, "aniso 1"))
for key in ["map_Pc", "map_Pcr", "map_aniso", "map_anisor"]:
    obj.named(key, mapped(key, GREY_WHITE, *METAL), "not drawn: " + key)
obj.named("Pc on a diffuse surface of glass", lines(*GLASS, "Pc 1"), "'Pc' has no place")


# OBJ
def coloured(f):
    f.colors = [(1, .1, .1)] * len(f.positions)


def concave(f):
    """Adds an arrow of four corners, one of which looks in; its outline is that of its two triangles."""
    f.positions += [(-1, -1, 1), (0, -.2, 1), (1, -1, 1), (0, 1, 1)]
    f.normals += [(0, 0, 1)] * 4
    f.uvs += [(0, 0)] * 4
    f.lines = ["f -4//-1 -3//-1 -2//-1 -1//-1"]


def concave_parts(f):
    concave(f)
    f.lines = ["f -4//-1 -3//-1 -1//-1", "f -3//-1 -2//-1 -1//-1"]


def smoothed(f):
    f.has_normals = False
    f.lines = ["s 1", *f.faces()]


def flat(f):
    f.has_normals = False
    f.lines = ["s off", *f.faces()]


obj.drawn("v with colours", coloured, colour(0, 1.3))
obj.drawn("f of four corners", concave, same(.001), base=concave_parts)
obj.drawn("vn", lambda f: setattr(f, "has_normals", False), differs(.005))
obj.drawn("s", smoothed, differs(.005), base=flat)
obj.drawn("vt", lambda f: f.map("map_Kd", RED_BLUE) or setattr(f, "uvs", [(u / 2, v) for u, v in f.uvs]), colour(0),
          base=lambda f: f.map("map_Kd", RED_BLUE))
obj.drawn("usemtl", lambda f: setattr(f, "material", list(RED)), colour(0, 1.3))
obj.named("usemtl (unknown)", lambda f: setattr(f, "lines", ["usemtl gone", *f.faces()]), "gone")
for key, text in [("o", "o a"), ("g", "g a b"), ("#", "# words")]:
    obj.silent(key, again(text), "names and comments")
for key, text in [("l", "l 1 2"), ("p", "p 1"), ("curv", "curv 0 1 1 2"), ("vp", "vp 1"), ("usemap", "usemap x")]:
    obj.named(key, again(text), key)

# PLY
ply.drawn("vertex.x, y, z", lambda f: setattr(f, "rows", [[x / 2, y / 2, z] for x, y, z in f.rows]), differs(.05))
ply.drawn("vertex.nx, ny, nz", lambda f: [f.column(f"property float n{axis}", [float(axis == "z")] * len(f.rows)) for axis in "xyz"],
          differs(.01))
ply.drawn("vertex.red, green, blue", lambda f: [f.column(f"property uchar {name}", [v] * len(f.rows))
                                               for name, v in [("red", 255), ("green", 30), ("blue", 30)]], colour(0, 1.2))
ply.drawn("face of four corners", lambda f: setattr(f, "faces", [
    [a, a + 1, a + SIDE + 2, a + SIDE + 1] for j in range(SIDE) for a in range(j * (SIDE + 1), j * (SIDE + 1) + SIDE)]), same(.001))
ply.silent("comment", lambda f: f.columns.insert(0, "comment words"), "text")
ply.silent("obj_info", lambda f: f.columns.insert(0, "obj_info words"), "text")
ply.named("vertex.confidence", lambda f: f.column("property float confidence", [1] * len(f.rows)), "confidence")
ply.named("edge", lambda f: f.head.append("element edge 1\nproperty int vertex1\nproperty int vertex2") or f.tail.append("0 1"), "edge")
