# SPDX-License-Identifier: Apache-2.0
"""The cases of every key of glTF 2.0 without extensions."""
import math
import struct

from expectations import LEFT, RIGHT, both, brighter, colour, darker, differs, drawn, named, refused, same, silent
from gltf_file import BYTE, FLOAT, SHORT, SIDE, UBYTE, UINT, USHORT, data_uri, dome, halves, png

RED_BLUE = halves((255, 40, 40), (40, 40, 255))
GREY_WHITE = halves((90, 90, 90), (255, 255, 255))
POSITIONS, NORMALS, UVS, TRIANGLES = dome()


def textured(f, picture=RED_BLUE, **more):
    f.pbr["baseColorTexture"] = f.texture(picture, **more)
    f.pbr["baseColorFactor"] = [1, 1, 1, 1]


def set_key(part, key, value):
    """Returns a change of one key in a part of the file ("pbr", "node", ...)."""
    return lambda f: getattr(f, part).__setitem__(key, value)


# asset and the top level
refused("asset.version", lambda f: f.doc["asset"].update(version="1.0"), "only glTF 2 is read")
refused("asset.minVersion", lambda f: f.doc["asset"].update(minVersion="2.1"), "minVersion is '2.1'")
silent("asset.generator", lambda f: f.doc["asset"].update(generator="x"), "text about the file")
silent("asset.copyright", lambda f: f.doc["asset"].update(copyright="x"), "text about the file")
silent("extras", lambda f: f.material.update(extras={"a": 1}), "an application's own")
silent("name", lambda f: f.node.update(name="x"), "text; messages and cameras show it")
named("(unknown key)", lambda f: f.material.update(shininess=3), "material 0: shininess is no key that is known here")
named("(unknown extension)", lambda f: f.use("FOO_bar", {}), "uses the extension FOO_bar")
refused("extensionsRequired", lambda f: f.doc.update(extensionsRequired=["FOO_bar"]), "requires the extension FOO_bar")
named("extensionsUsed", lambda f: f.doc["extensionsUsed"].append("FOO_baz"), "uses the extension FOO_baz")


def second_scene(f):
    f.doc["nodes"].append({"mesh": 0, "scale": [0.3, 0.3, 0.3]})
    f.doc["scenes"].append({"nodes": [3, 1, 2], "name": "small"})


def pick_second(f):
    second_scene(f)
    f.doc["scene"] = 1


named("scene", pick_second, "'small' is drawn, and not '0'")
named("scenes", second_scene, "'0' is drawn, and not 'small'")
drawn("scene.nodes", lambda f: f.doc["scenes"][0].update(nodes=[1, 2]) or f.doc["nodes"].append({"mesh": 0, "scale": [.3, .3, .3]})
      or f.doc["scenes"][0]["nodes"].append(3), darker())

# nodes
drawn("node.translation", set_key("node", "translation", [0.5, 0, 0]), both(darker(part=(0, 0, .3, 1)), brighter(part=(.8, 0, 1, 1))))
drawn("node.rotation", set_key("node", "rotation", [0, math.sin(0.5), 0, math.cos(0.5)]), darker(part=(0, 0, .2, 1)))
drawn("node.scale", set_key("node", "scale", [0.5, 0.5, 0.5]), darker())
drawn("node.matrix", set_key("node", "matrix", [.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, .2, .1, 0, 1]), same(1e-4),
      base=lambda f: f.node.update(translation=[.2, .1, 0], scale=[.5, .5, .5]))
drawn("node.children", lambda f: f.doc["nodes"].append({"children": [0], "scale": [.5, .5, .5]}) or
      f.doc["scenes"][0].update(nodes=[3, 1, 2]), same(1e-4), base=lambda f: f.node.update(scale=[.5, .5, .5]))
drawn("node.mesh", lambda f: f.doc["nodes"].append({"mesh": 0, "translation": [0, 0, -3], "scale": [9, 9, 1]}) or
      f.doc["scenes"][0]["nodes"].append(3), brighter())
drawn("node.camera", lambda f: f.doc["nodes"][1].update(translation=[0, 0, 6]), differs(.1))
named("node.scale (singular)", lambda f: f.doc["nodes"].append({"mesh": 0, "name": "flat", "scale": [1, 0, 1]}) or
      f.doc["scenes"][0]["nodes"].append(3), "node 3 'flat': mesh is not drawn: the matrix of the node")
drawn("node.scale (mirrored)", set_key("node", "scale", [-1, 1, 1]), same(.02))
refused("node.children (circle)", lambda f: f.node.update(children=[0]), "node 0: is its own ancestor")
named("node.skin", lambda f: f.node.update(skin=0) or f.doc.update(skins=[{"joints": [1]}]), "skin moves nothing")


def skinned(f):
    """The mesh hangs on node 3, which is half as large, from where it stood."""
    count = len(POSITIONS)
    f.primitive["attributes"].update(JOINTS_0=f.accessor([(0, 0, 0, 0)] * count, UBYTE, "VEC4"),
                                     WEIGHTS_0=f.accessor([(1, 0, 0, 0)] * count, FLOAT, "VEC4"))
    f.doc["nodes"].append({"scale": [.5, .5, .5]})
    f.doc["scenes"][0]["nodes"].append(3)
    f.node.update(skin=0)
    f.doc.update(skins=[{"joints": [3], "skeleton": 3}])


drawn("skins", skinned, darker())
refused("skins (joint out of range)", lambda f: skinned(f) or f.doc["skins"][0].update(joints=[9]), "skin 0: joints holds")


def morphed(f):
    f.primitive["targets"] = [{"POSITION": f.accessor([(0, 0, 1)] * len(POSITIONS), FLOAT, "VEC3")}]


drawn("primitive.targets", morphed, same(0))
drawn("mesh.weights", lambda f: morphed(f) or f.doc["meshes"][0].update(weights=[1]), brighter())
drawn("node.weights", lambda f: morphed(f) or f.node.update(weights=[1]), brighter())


def animated(f, times=(0, 1), values=((-9, 0, 0), (0, 0, 0)), **sampler):
    """The mesh comes into the picture from the left; at 0 s it is not there."""
    f.doc.update(animations=[{
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": f.accessor(times, FLOAT, "SCALAR"), "output": f.accessor(values, FLOAT, "VEC3"), **sampler}]}])


drawn("animations", animated, darker())
drawn("sampler.interpolation", lambda f: animated(f, interpolation="STEP"), darker())
refused("sampler.input (falls)", lambda f: animated(f, times=(1, 0)), "input does not rise at key 1")
refused("sampler.interpolation (unknown)", lambda f: animated(f, interpolation="ROUND"), "'ROUND'; it must be LINEAR")

# cameras
drawn("camera.perspective.yfov", lambda f: f.camera["perspective"].update(yfov=1.2), darker())
silent("camera.perspective.aspectRatio", lambda f: f.camera["perspective"].update(aspectRatio=3), "the picture's size says it")
silent("camera.perspective.znear", lambda f: f.camera["perspective"].update(znear=3.9), "a ray tracer clips nothing")
silent("camera.perspective.zfar", lambda f: f.camera["perspective"].update(zfar=1), "a ray tracer clips nothing")
drawn("camera.perspective", lambda f: f.camera["perspective"].update(yfov=.3), brighter())
named("camera.type", lambda f: f.camera.update(type="fisheye"), "camera 0: type is 'fisheye'")
named("camera.orthographic", lambda f: f.doc.update(cameras=[{"type": "orthographic", "orthographic": {
    "xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}]), "is orthographic, which is not drawn")

# meshes
drawn("mesh.primitives", lambda f: f.doc["meshes"][0]["primitives"].append(
    {"attributes": {"POSITION": f.accessor([(-9, -9, -1), (9, -9, -1), (0, 9, -1)], FLOAT, "VEC3")}}), brighter())
drawn("primitive.attributes.POSITION", lambda f: f.attributes.update(
    POSITION=f.accessor([(x / 2, y / 2, z) for x, y, z in POSITIONS], FLOAT, "VEC3")), darker())
drawn("primitive.attributes.NORMAL", lambda f: f.attributes.pop("NORMAL"), differs(.005))
drawn("primitive.attributes.TEXCOORD_0", lambda f: textured(f) or f.attributes.update(
    TEXCOORD_0=f.accessor([(u / 2, v) for u, v in UVS], FLOAT, "VEC2")), colour(0), base=textured)
drawn("primitive.indices", lambda f: f.primitive.update(indices=f.accessor([0, 4, 80], USHORT, "SCALAR")), darker())
drawn("primitive.indices (none)", lambda f: f.primitive.pop("indices") is not None and f.attributes.update(
    POSITION=f.accessor([POSITIONS[i] for t in TRIANGLES for i in t], FLOAT, "VEC3"),
    NORMAL=f.accessor([NORMALS[i] for t in TRIANGLES for i in t], FLOAT, "VEC3"),
    TEXCOORD_0=f.accessor([UVS[i] for t in TRIANGLES for i in t], FLOAT, "VEC2")), same(1e-4))
drawn("primitive.material", lambda f: f.doc["materials"].append({"pbrMetallicRoughness": {
    "baseColorFactor": [1, 0, 0, 1]}}) or f.primitive.update(material=1), colour(0, 1.5))
drawn("primitive.material (none)", lambda f: f.primitive.pop("material"), same(1e-4), base=lambda f: f.doc.update(materials=[{}]))
for mode, name in enumerate(["points", "lines", "line loops", "line strips"]):
    named(f"primitive.mode {mode}", lambda f, mode=mode: f.doc["meshes"][0]["primitives"].append(
        {**f.primitive, "mode": mode}), f"mode is {name}, which have no surface")


def strip(f):
    rows = []
    for j in range(SIDE):  # triangles without area join the rows
        row = [k for i in range(SIDE + 1) for k in ((j + 1) * (SIDE + 1) + i, j * (SIDE + 1) + i)]
        rows += ([row[0]] if rows else []) + row + [row[-1]]
    f.primitive.update(mode=5, indices=f.accessor(rows, USHORT, "SCALAR"))


def fan(f):
    f.primitive.update(mode=6, indices=f.accessor([40, 0, 8, 80, 72, 0], USHORT, "SCALAR"))


drawn("primitive.mode 4", lambda f: f.primitive.update(mode=4), same(0))
drawn("primitive.mode 5", strip, same(.02))
drawn("primitive.mode 6", fan, same(1e-4), base=lambda f: f.primitive.update(
    indices=f.accessor([40, 0, 8, 40, 8, 80, 40, 80, 72, 40, 72, 0], USHORT, "SCALAR")))
drawn("primitive.attributes.COLOR_0", lambda f: f.attributes.update(
    COLOR_0=f.accessor([(1, 0.1, 0.1, 1)] * len(POSITIONS), FLOAT, "VEC4")), colour(0, 1.5))
drawn("primitive.attributes.COLOR_0 (bytes)", lambda f: f.attributes.update(
    COLOR_0=f.accessor([(255, 20, 20)] * len(POSITIONS), UBYTE, "VEC3", normalized=True)), colour(0, 1.5))
named("primitive.attributes.COLOR_1", lambda f: f.attributes.update(
    COLOR_1=f.accessor([(1, 0, 0)] * len(POSITIONS), FLOAT, "VEC3")), "attributes.COLOR_1 is not read")
silent("primitive.attributes._CUSTOM", lambda f: f.attributes.update(_CUSTOM=0), "an application's own")
silent("primitive.attributes.TEXCOORD_1 (unused)", lambda f: f.attributes.update(TEXCOORD_1=2), "no texture uses it")
refused("primitive.attributes.JOINTS_0 (alone)", lambda f: f.attributes.update(JOINTS_0=f.accessor(
    [(0, 0, 0, 0)] * len(POSITIONS), UBYTE, "VEC4")), "JOINTS_0 and WEIGHTS_0 come together")
refused("primitive.attributes.WEIGHTS_0 (zero)", lambda f: skinned(f) or f.attributes.update(
    WEIGHTS_0=f.accessor([(0, 0, 0, 0)] * len(POSITIONS), FLOAT, "VEC4")), "of vertex 0 sum to 0")
refused("primitive.attributes.WEIGHTS_0 (alone)", lambda f: f.attributes.update(WEIGHTS_0=f.accessor(
    [(1, 0, 0, 0)] * len(POSITIONS), FLOAT, "VEC4")), "JOINTS_0 and WEIGHTS_0 come together")
drawn("textureInfo.texCoord", lambda f: textured(f, texCoord=1) or f.attributes.update(
    TEXCOORD_1=f.accessor([(.1, .1)] * len(UVS), FLOAT, "VEC2")), colour(0), base=textured)
drawn("textureInfo.texCoord 3", lambda f: textured(f, texCoord=3) or f.attributes.update(
    TEXCOORD_3=f.accessor([(.1, .1)] * len(UVS), FLOAT, "VEC2")), colour(0), base=textured)
BUMPS = png(8, 8, lambda x, y: (128 + (100 if x % 4 < 2 else -100), 128, 160))
drawn("primitive.attributes.TANGENT", lambda f: f.material.update(normalTexture=f.texture(BUMPS)) or f.attributes.update(
    TANGENT=f.accessor([(0, 1, 0, 1)] * len(POSITIONS), FLOAT, "VEC4")), differs(.02),
    base=lambda f: f.material.update(normalTexture=f.texture(BUMPS)))

# accessors, views, buffers
drawn("accessor.bufferView", lambda f: f.attributes.update(POSITION=f.accessor(
    [(x, y, 0) for x, y, z in POSITIONS], FLOAT, "VEC3")), differs(.005))


def offset(f):
    f.view(b"\1" * 12 + b"".join(struct.pack("<3f", *p) for p in POSITIONS))
    f.doc["accessors"].append({"bufferView": len(f.doc["bufferViews"]) - 1, "byteOffset": 12, "componentType": FLOAT,
                               "count": len(POSITIONS), "type": "VEC3"})
    f.attributes["POSITION"] = len(f.doc["accessors"]) - 1


def interleaved(f):
    f.view(b"".join(struct.pack("<6f", *p, *n) for p, n in zip(POSITIONS, NORMALS)), byteStride=24)
    for at, name in [(0, "POSITION"), (12, "NORMAL")]:
        f.doc["accessors"].append({"bufferView": len(f.doc["bufferViews"]) - 1, "byteOffset": at, "componentType": FLOAT,
                                   "count": len(POSITIONS), "type": "VEC3"})
        f.attributes[name] = len(f.doc["accessors"]) - 1


drawn("accessor.byteOffset", offset, same(0))
drawn("bufferView.byteStride", interleaved, same(0))
drawn("bufferView.byteOffset", lambda f: None, same(0), why="each view of the dome has one")
flat_indices = [i for t in TRIANGLES for i in t]
drawn("accessor.componentType 5121", lambda f: f.primitive.update(indices=f.accessor(flat_indices, UBYTE, "SCALAR")), same(0))
drawn("accessor.componentType 5125", lambda f: f.primitive.update(indices=f.accessor(flat_indices, UINT, "SCALAR")), same(0))
refused("accessor.componentType", lambda f: f.doc["accessors"][0].update(componentType=5124), "accessor 0: componentType is 5124")
drawn("accessor.normalized", lambda f: textured(f) or f.attributes.update(TEXCOORD_0=f.accessor(
    [(round(u * 65535), round(v * 65535)) for u, v in UVS], USHORT, "VEC2", normalized=True)), same(.01), base=textured)
drawn("accessor.count", lambda f: f.doc["accessors"][3].update(count=192), darker())
refused("accessor.type", lambda f: f.doc["accessors"][0].update(type="VEC5"), "accessor 0: type is 'VEC5'")
silent("accessor.min", lambda f: f.doc["accessors"][0].update(min=[0, 0, 0]), "bounds are computed")
silent("accessor.max", lambda f: f.doc["accessors"][0].update(max=[0, 0, 0]), "bounds are computed")
MOVED = {10: (-.7, -.7, 2), 40: (0, 0, 1.5)}


def sparse(f, component=USHORT):
    indices = struct.pack("<2" + {UBYTE: "B", USHORT: "H", UINT: "I"}[component], *MOVED)
    f.doc["accessors"][0]["sparse"] = {
        "count": 2, "indices": {"bufferView": f.view(b"\0" * 4 + indices), "byteOffset": 4, "componentType": component},
        "values": {"bufferView": f.view(b"\0" * 4 + b"".join(struct.pack("<3f", *p) for p in MOVED.values())), "byteOffset": 4}}


def directly(f):
    f.attributes["POSITION"] = f.accessor([MOVED.get(i, p) for i, p in enumerate(POSITIONS)], FLOAT, "VEC3")


drawn("accessor.sparse", sparse, differs(.01))
for component in [UBYTE, USHORT, UINT]:
    drawn(f"accessor.sparse.indices {component}", lambda f, c=component: sparse(f, c), same(0), base=directly)
refused("accessor.sparse.count", lambda f: sparse(f) or f.doc["accessors"][0]["sparse"].update(count=99), "sparse.count is 99")
refused("accessor.sparse.values.bufferView", lambda f: sparse(f) or f.doc["accessors"][0]["sparse"]["values"].update(bufferView=99),
        "sparse.values.bufferView is 99")


def zeros(f):
    f.doc["accessors"].append({"componentType": FLOAT, "count": len(POSITIONS), "type": "VEC2"})
    textured(f)
    f.attributes["TEXCOORD_0"] = len(f.doc["accessors"]) - 1


drawn("accessor without bufferView", zeros, colour(0), base=textured)
refused("bufferView.byteLength", lambda f: f.doc["bufferViews"][0].update(byteLength=10), "bytes behind bufferView 0")
refused("bufferView.buffer", lambda f: f.doc["bufferViews"][0].update(buffer=7), "bufferView 0: buffer is 7")
silent("bufferView.target", lambda f: f.doc["bufferViews"][0].update(target=34962), "a hint for graphics cards")


def separate(f):
    f.doc["buffers"][0]["uri"] = "the%20bytes.bin"
    f.files["the bytes.bin"] = f.bytes


drawn("buffer.uri", separate, same(0))
drawn("buffer.byteLength", lambda f: None, same(0), suffix=".glb", why="binary glTF, whose chunk may be longer")
refused("buffer.uri (missing)", lambda f: f.doc["buffers"][0].update(uri="gone.bin"), "buffer 0: uri 'gone.bin' no such file")

# textures
drawn("texture.source", textured, both(colour(0, part=LEFT), colour(2, part=RIGHT)))
drawn("image.uri", lambda f: textured(f) or f.doc["images"][0].update(uri="a%2Epng") or f.files.update({"a.png": RED_BLUE}),
      same(0), base=textured)
drawn("image.bufferView", lambda f: textured(f) or f.doc["images"].__setitem__(
    0, {"bufferView": f.view(RED_BLUE), "mimeType": "image/png"}), same(0), base=textured)
silent("image.mimeType", lambda f: textured(f) or f.doc["images"][0].update(mimeType="image/jpeg"),
       "a picture's first bytes say what it is", base=textured)
named("image.uri (missing)", lambda f: textured(f) or f.doc["images"][0].update(uri="gone.png"), "image 0: uri 'gone.png' no such file")
named("image.uri (broken)", lambda f: textured(f) or f.doc["images"][0].update(uri=data_uri(b"no picture")), "is no PNG, JPEG or WebP")
drawn("image of 16 bits", lambda f: textured(f, halves((65535, 10000, 10000), (10000, 10000, 65535), depth=16)),
        both(colour(0, part=LEFT), colour(2, part=RIGHT)))


def glowing(picture):
    def change(f):
        f.material.update(emissiveFactor=[1, 1, 1], emissiveTexture=f.texture(picture))
        f.use("KHR_materials_emissive_strength", {"emissiveStrength": 1000})
    return change


# 400 of 65535, rounded to 8 bits, would be 2 of 255, a quarter brighter.
drawn("image of 16 bits (all of them)", glowing(halves((400,) * 3, (400,) * 3, depth=16)), darker(.85),
      base=glowing(halves((2,) * 3, (2,) * 3)))


def spread(f, **sampler):
    textured(f)
    f.attributes["TEXCOORD_0"] = f.accessor([(2 * u - .25, 2 * v - .25) for u, v in UVS], FLOAT, "VEC2")
    if sampler:
        f.doc["samplers"].append(sampler)
        f.doc["textures"][0]["sampler"] = 0


drawn("sampler.wrapS 33071", lambda f: spread(f, wrapS=33071), differs(.05), base=spread)
drawn("sampler.wrapS 33648", lambda f: spread(f, wrapS=33648), differs(.05), base=spread)
drawn("sampler.wrapT 33071", lambda f: spread(f, wrapT=33071) or f.doc["images"][0].update(uri=data_uri(TALL)), differs(.05),
        base=lambda f: spread(f) or f.doc["images"][0].update(uri=data_uri(TALL)))
TALL = png(8, 8, lambda x, y: (255, 40, 40) if y < 4 else (40, 40, 255))
drawn("sampler.wrapS 10497", lambda f: spread(f, wrapS=10497), same(0), base=spread)
drawn("sampler.magFilter 9728", lambda f: textured(f, halves((255, 0, 0), (0, 0, 255), 2), sampler={"magFilter": 9728}), differs(.01),
        base=lambda f: textured(f, halves((255, 0, 0), (0, 0, 255), 2)))
silent("sampler.minFilter", lambda f: textured(f, sampler={"minFilter": 9984}), "samples do what it asks for", base=textured)
drawn("texture.sampler", lambda f: spread(f, magFilter=9729), same(0), base=spread)
named("textureInfo.index", lambda f: textured(f) or f.pbr["baseColorTexture"].update(index=9), "baseColorTexture.index is 9")

# materials
drawn("material.pbrMetallicRoughness.baseColorFactor", set_key("pbr", "baseColorFactor", [1, .1, .1, 1]), colour(0, 1.5))
drawn("material.pbrMetallicRoughness.baseColorTexture", textured, colour(0, part=LEFT))
drawn("material.pbrMetallicRoughness.metallicFactor", set_key("pbr", "metallicFactor", 1), differs(.1))
drawn("material.pbrMetallicRoughness.roughnessFactor", set_key("pbr", "roughnessFactor", .1), differs(.02))
drawn("material.pbrMetallicRoughness.metallicRoughnessTexture", lambda f: f.pbr.update(
    metallicFactor=1, metallicRoughnessTexture=f.texture(halves((0, 255, 0), (0, 255, 255)))), differs(.05),
    base=set_key("pbr", "metallicFactor", 1))
drawn("material.normalTexture", lambda f: f.material.update(normalTexture=f.texture(BUMPS)), differs(.05))
drawn("material.normalTexture.scale", lambda f: f.material.update(normalTexture=f.texture(BUMPS, scale=.1)), differs(.05),
      base=lambda f: f.material.update(normalTexture=f.texture(BUMPS)))
silent("material.occlusionTexture", lambda f: f.material.update(occlusionTexture=f.texture(GREY_WHITE)), "light computes it")
silent("material.occlusionTexture.strength", lambda f: f.material.update(occlusionTexture=f.texture(GREY_WHITE, strength=.5)),
       "light computes it")
drawn("material.emissiveFactor", lambda f: f.material.update(emissiveFactor=[0, 1, 0]), colour(1, 1.3))
drawn("material.emissiveTexture", lambda f: f.material.update(emissiveFactor=[1, 1, 1], emissiveTexture=f.texture(RED_BLUE)),
      both(colour(0, 1.05, LEFT), colour(2, 1.05, RIGHT)))
HALF_CLEAR = halves((128, 128, 128, 0), (128, 128, 128, 255), alpha=True)
drawn("material.alphaMode MASK", lambda f: textured(f, HALF_CLEAR) or f.material.update(alphaMode="MASK"), differs(.05),
        base=lambda f: textured(f, HALF_CLEAR))
drawn("material.alphaMode BLEND", lambda f: f.material.update(alphaMode="BLEND") or f.pbr.update(baseColorFactor=[.5, .5, .5, .2]),
        differs(.05))
drawn("material.alphaMode OPAQUE", lambda f: f.material.update(alphaMode="OPAQUE") or f.pbr.update(baseColorFactor=[.5, .5, .5, .2]),
      same(0))
drawn("material.alphaCutoff", lambda f: f.material.update(alphaMode="MASK", alphaCutoff=.1) or f.pbr.update(
    baseColorFactor=[.5, .5, .5, .2]), differs(.05),
    base=lambda f: f.material.update(alphaMode="MASK") or f.pbr.update(baseColorFactor=[.5, .5, .5, .2]))
drawn("material.doubleSided", lambda f: behind(f) or f.material.update(doubleSided=True), brighter(), base=lambda f: behind(f))


def behind(f):
    f.node["rotation"] = [0, 1, 0, 0]
    f.material["emissiveFactor"] = [1, 1, 1]
