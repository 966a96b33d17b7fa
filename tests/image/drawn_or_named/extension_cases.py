# SPDX-License-Identifier: Apache-2.0
"""The cases of the keys of every ratified extension of glTF 2.0 (KHR and EXT), and of the archived one still in use."""
import math

import core_cases
from core_cases import (BUMPS, GREY_WHITE, NORMALS, POSITIONS, RED_BLUE, TRIANGLES, UVS, behind, textured)
from expectations import LEFT, RIGHT, both, brighter, colour, darker, differs, drawn, named, refused, same, silent
from gltf_file import BYTE, FLOAT, PACKED, SHORT, USHORT, data_uri, halves


def extension(name, **keys):
    """Returns a change that puts the extension with these keys into the material."""
    return lambda f: f.use(name, keys) and None


def with_texture(name, key, picture, **keys):
    return lambda f: f.use(name, {**keys, key: f.texture(picture)}) and None


def then(*changes):
    def change(f):
        for one in changes:
            one(f)
    return change


# unlit, emissive strength, ior, specular
drawn("KHR_materials_unlit", extension("KHR_materials_unlit"), differs(.1))
drawn("KHR_materials_emissive_strength.emissiveStrength", then(
    lambda f: f.material.update(emissiveFactor=[.2, .2, .2]), extension("KHR_materials_emissive_strength", emissiveStrength=10)),
    brighter(1.5), base=lambda f: f.material.update(emissiveFactor=[.2, .2, .2]))
drawn("KHR_materials_ior.ior", extension("KHR_materials_ior", ior=2.5), brighter())
drawn("KHR_materials_ior.ior 0", extension("KHR_materials_ior", ior=0), brighter(1.1))
SPECULAR = "KHR_materials_specular"
drawn(SPECULAR + ".specularFactor", extension(SPECULAR, specularFactor=0), differs(.005))
drawn(SPECULAR + ".specularColorFactor", extension(SPECULAR, specularColorFactor=[20, 1, 1]), colour(0, 1.05))
drawn(SPECULAR + ".specularTexture", with_texture(SPECULAR, "specularTexture", halves((0, 0, 0, 0), (0, 0, 0, 255), alpha=True)),
      differs(.003))
drawn(SPECULAR + ".specularColorTexture", with_texture(SPECULAR, "specularColorTexture", RED_BLUE, specularColorFactor=[20, 20, 20]),
      differs(.05), base=extension(SPECULAR, specularColorFactor=[20, 20, 20]))

# clearcoat
COAT = "KHR_materials_clearcoat"
MATTE = lambda f: f.pbr.update(roughnessFactor=1)  # noqa: E731
COATED = extension(COAT, clearcoatFactor=1)
drawn(COAT + ".clearcoatFactor", then(MATTE, COATED), differs(.01), base=MATTE)
drawn(COAT + ".clearcoatRoughnessFactor", then(MATTE, extension(COAT, clearcoatFactor=1, clearcoatRoughnessFactor=.6)),
        differs(.005), base=then(MATTE, COATED))
drawn(COAT + ".clearcoatTexture", then(MATTE, with_texture(COAT, "clearcoatTexture", halves((0, 0, 0), (255, 0, 0)), clearcoatFactor=1)),
        differs(.005), base=then(MATTE, COATED))
drawn(COAT + ".clearcoatRoughnessTexture", then(MATTE, with_texture(
    COAT, "clearcoatRoughnessTexture", halves((0, 0, 0), (0, 255, 0)), clearcoatFactor=1, clearcoatRoughnessFactor=.8)),
    differs(.005), base=then(MATTE, extension(COAT, clearcoatFactor=1, clearcoatRoughnessFactor=.8)))
drawn(COAT + ".clearcoatNormalTexture", then(MATTE, with_texture(COAT, "clearcoatNormalTexture", BUMPS, clearcoatFactor=1)),
        differs(.005), base=then(MATTE, COATED))

# sheen
SHEEN = "KHR_materials_sheen"
VELVET = extension(SHEEN, sheenColorFactor=[1, 0, 0], sheenRoughnessFactor=.5)
drawn(SHEEN + ".sheenColorFactor", VELVET, colour(0, 1.02))
drawn(SHEEN + ".sheenRoughnessFactor", extension(SHEEN, sheenColorFactor=[1, 0, 0], sheenRoughnessFactor=.1), differs(.005), base=VELVET)
drawn(SHEEN + ".sheenColorTexture", with_texture(SHEEN, "sheenColorTexture", RED_BLUE, sheenColorFactor=[1, 1, 1],
                                                   sheenRoughnessFactor=.5), differs(.005),
        base=extension(SHEEN, sheenColorFactor=[1, 1, 1], sheenRoughnessFactor=.5))
drawn(SHEEN + ".sheenRoughnessTexture", with_texture(
    SHEEN, "sheenRoughnessTexture", halves((0, 0, 0, 40), (0, 0, 0, 255), alpha=True), sheenColorFactor=[1, 0, 0],
    sheenRoughnessFactor=1), differs(.002), base=extension(SHEEN, sheenColorFactor=[1, 0, 0], sheenRoughnessFactor=1))

# transmission and volume
THROUGH, VOLUME = "KHR_materials_transmission", "KHR_materials_volume"


def backdrop(f):
    """Puts a red wall behind the dome that sheds light of its own, and makes the dome white and smooth."""
    f.doc["materials"].append({"emissiveFactor": [1, .1, .1]})
    f.doc["meshes"].append({"primitives": [{"attributes": {"POSITION": f.accessor(
        [(-9, -9, -2), (9, -9, -2), (0, 9, -2)], FLOAT, "VEC3")}, "material": 1}]})
    f.doc["nodes"].append({"mesh": 1})
    f.doc["scenes"][0]["nodes"].append(3)
    f.pbr.update(baseColorFactor=[1, 1, 1, 1], roughnessFactor=0)


def closed(f):
    """Puts a reversed copy right below the dome, which makes it a body, before the backdrop."""
    backdrop(f)
    edge = [(x, y, z - .02) for x, y, z in core_cases.POSITIONS]
    f.doc["meshes"].append({"primitives": [{"attributes": {"POSITION": f.accessor(edge, FLOAT, "VEC3")}, "material": 0,
                                            "indices": f.accessor([k for a, b, c in core_cases.TRIANGLES for k in (a, c, b)],
                                                                  USHORT, "SCALAR")}]})
    f.doc["nodes"].append({"mesh": 2})
    f.doc["scenes"][0]["nodes"].append(4)


drawn(THROUGH + ".transmissionFactor", then(backdrop, extension(THROUGH, transmissionFactor=1)), colour(0, 1.2, LEFT), base=backdrop)
drawn(THROUGH + ".transmissionTexture", then(backdrop, with_texture(
    THROUGH, "transmissionTexture", halves((0, 0, 0), (255, 0, 0)), transmissionFactor=1)), differs(.05),
    base=then(backdrop, extension(THROUGH, transmissionFactor=1)))
GLASS = then(backdrop, extension(THROUGH, transmissionFactor=1), extension(VOLUME, thicknessFactor=1))
drawn(VOLUME + ".thicknessFactor", GLASS, differs(.05), base=backdrop)
silent(VOLUME + ".thicknessTexture", then(backdrop, extension(THROUGH, transmissionFactor=1), with_texture(
    VOLUME, "thicknessTexture", GREY_WHITE, thicknessFactor=1)), "inside is as thick as the mesh is", base=GLASS)
THICK = then(closed, extension(THROUGH, transmissionFactor=1))
drawn(VOLUME + ".attenuationColor", then(THICK, extension(
    VOLUME, thicknessFactor=1, attenuationDistance=.02, attenuationColor=[.2, .2, 1])), colour(2),
    base=then(THICK, extension(VOLUME, thicknessFactor=1)))
drawn(VOLUME + ".attenuationDistance", then(THICK, extension(
    VOLUME, thicknessFactor=1, attenuationDistance=.01, attenuationColor=[.2, .2, 1])), differs(.01),
    base=then(THICK, extension(VOLUME, thicknessFactor=1, attenuationDistance=.1, attenuationColor=[.2, .2, 1])))

# anisotropy
TURNED = "KHR_materials_anisotropy"
METAL = lambda f: f.pbr.update(metallicFactor=1, roughnessFactor=.4)  # noqa: E731
drawn(TURNED + ".anisotropyStrength", then(METAL, extension(TURNED, anisotropyStrength=1)), differs(.02), base=METAL)
drawn(TURNED + ".anisotropyRotation", then(METAL, extension(TURNED, anisotropyStrength=1, anisotropyRotation=math.pi / 2)),
        differs(.02), base=then(METAL, extension(TURNED, anisotropyStrength=1)))
drawn(TURNED + ".anisotropyTexture", then(METAL, with_texture(TURNED, "anisotropyTexture", halves((128, 255, 255), (255, 128, 255)),
                                                               anisotropyStrength=1)), differs(.01),
        base=then(METAL, extension(TURNED, anisotropyStrength=1)))

# what is known and not drawn
named("KHR_materials_iridescence", extension("KHR_materials_iridescence", iridescenceFactor=1), "KHR_materials_iridescence is not drawn")
named("KHR_materials_dispersion", extension("KHR_materials_dispersion", dispersion=1), "KHR_materials_dispersion is not drawn")
named("KHR_materials_diffuse_transmission", extension("KHR_materials_diffuse_transmission", diffuseTransmissionFactor=1),
      "KHR_materials_diffuse_transmission is not drawn")
for name in ["KHR_animation_pointer", "KHR_interactivity", "KHR_node_hoverability", "KHR_node_selectability", "KHR_gaussian_splatting",
             "EXT_lights_image_based", "EXT_texture_avif", "MSFT_lod"]:
    named(name, lambda f, name=name: f.doc["extensionsUsed"].append(name), f"uses the extension {name}")
silent("KHR_xmp_json_ld", lambda f: f.doc["extensionsUsed"].append("KHR_xmp_json_ld"), "text about the file")

# specular-glossiness (archived)
OLD = "KHR_materials_pbrSpecularGlossiness"
drawn(OLD, extension(OLD, diffuseFactor=[.5, .5, .5, 1], specularFactor=[.04, .04, .04], glossinessFactor=.5), same(1e-4))
drawn(OLD + ".diffuseFactor", extension(OLD, diffuseFactor=[1, .1, .1, 1], specularFactor=[0, 0, 0]), colour(0))
drawn(OLD + ".diffuseTexture", with_texture(OLD, "diffuseTexture", RED_BLUE, specularFactor=[0, 0, 0]), colour(0, part=LEFT))
drawn(OLD + ".specularFactor", extension(OLD, specularFactor=[0, 0, 0]), darker(), base=extension(OLD))
drawn(OLD + ".glossinessFactor", extension(OLD, glossinessFactor=.3), differs(.05), base=extension(OLD))
drawn(OLD + ".specularGlossinessTexture", with_texture(OLD, "specularGlossinessTexture", halves(
    (255, 255, 255, 255), (255, 255, 255, 30), alpha=True)), differs(.02), base=extension(OLD))

# texture transform
MOVE = "KHR_texture_transform"


def moved(**keys):
    def change(f):
        textured(f)
        f.use(MOVE, keys, f.pbr["baseColorTexture"])
    return change


drawn(MOVE + ".offset", moved(offset=[.5, 0]), both(colour(2, part=LEFT), colour(0, part=RIGHT)), base=textured)
drawn(MOVE + ".scale", moved(scale=[.5, 1]), colour(0, part=RIGHT), base=textured)
drawn(MOVE + ".rotation", moved(offset=[1, 1], rotation=math.pi), both(colour(2, part=LEFT), colour(0, part=RIGHT)), base=textured)
drawn(MOVE + ".texCoord", lambda f: moved(texCoord=1)(f) or f.attributes.update(
    TEXCOORD_1=f.accessor([(.1, .1)] * len(UVS), FLOAT, "VEC2")), colour(0), base=textured)

# lamps
drawn("KHR_lights_punctual.intensity", lambda f: f.lamp.update(intensity=683 * 60), brighter(1.3))
drawn("KHR_lights_punctual.color", lambda f: f.lamp.update(color=[1, .2, .2]), colour(0, 1.2))
drawn("KHR_lights_punctual.type directional", lambda f: f.lamp.update(type="directional", intensity=683), differs(.02))
drawn("KHR_lights_punctual.type spot", lambda f: f.lamp.update(type="spot"), darker())
named("KHR_lights_punctual.type", lambda f: f.lamp.update(type="laser"), "light 0: type is 'laser'")
named("KHR_lights_punctual.range", lambda f: f.lamp.update(range=1), "range is a hint that is not followed")
AIMED = lambda f: f.doc["nodes"][2].update(translation=[0, 0, 4])  # noqa: E731
drawn("KHR_lights_punctual.spot.outerConeAngle", then(AIMED, lambda f: f.lamp.update(type="spot", spot={"outerConeAngle": .1})), darker(),
      base=then(AIMED, lambda f: f.lamp.update(type="spot")))
drawn("KHR_lights_punctual.spot.innerConeAngle", then(AIMED, lambda f: f.lamp.update(type="spot", spot={
    "innerConeAngle": .29, "outerConeAngle": .3})), brighter(), base=then(AIMED, lambda f: f.lamp.update(
        type="spot", spot={"outerConeAngle": .3})))
named("KHR_lights_punctual.light", lambda f: f.doc["nodes"][2]["extensions"]["KHR_lights_punctual"].update(light=5), "light is 5")

# variants, visibility, instancing
named("KHR_materials_variants", lambda f: f.use("KHR_materials_variants", {"variants": [{"name": "red"}, {"name": "blue"}]}, f.doc),
      "holds the variants 'red', 'blue'")
named("KHR_materials_variants.mappings", lambda f: f.use("KHR_materials_variants", {"variants": [{"name": "red"}]}, f.doc) and f.use(
    "KHR_materials_variants", {"mappings": [{"material": 0, "variants": [0]}]}, f.primitive), "its default is drawn")


def two(f):
    f.doc["nodes"].append({"mesh": 0, "scale": [.3, .3, .3], "translation": [0, 0, 1]})
    f.doc["scenes"][0]["nodes"].append(3)


drawn("KHR_node_visibility.visible", then(two, lambda f: f.use("KHR_node_visibility", {"visible": False}, f.node)), darker(), base=two)
INSTANCES = "EXT_mesh_gpu_instancing"


def many(f, **parts):
    f.use(INSTANCES, {"attributes": {name: f.accessor(rows, FLOAT, "VEC4" if name == "ROTATION" else "VEC3")
                                     for name, rows in parts.items()}}, f.node)


def placed(*nodes):
    def change(f):
        f.node.update(nodes[0])
        for node in nodes[1:]:
            f.doc["nodes"].append({"mesh": 0, **node})
            f.doc["scenes"][0]["nodes"].append(len(f.doc["nodes"]) - 1)
    return change


drawn(INSTANCES + ".TRANSLATION", lambda f: many(f, TRANSLATION=[(-.5, 0, 0), (.5, 0, .2)]), same(1e-4),
      base=placed({"translation": [-.5, 0, 0]}, {"translation": [.5, 0, .2]}))
drawn(INSTANCES + ".SCALE", lambda f: many(f, SCALE=[(.5, .5, .5)]), same(1e-4), base=placed({"scale": [.5, .5, .5]}))
drawn(INSTANCES + ".ROTATION", lambda f: many(f, ROTATION=[(0, math.sin(.3), 0, math.cos(.3))]), same(1e-4),
      base=placed({"rotation": [0, math.sin(.3), 0, math.cos(.3)]}))
named(INSTANCES + " (other attribute)", lambda f: many(f, TRANSLATION=[(0, 0, 0)], COLOR_0=[(1, 0, 0)]), "attributes.COLOR_0 is not read")


# packed geometry and pictures
def quantised(f):
    f.doc["extensionsUsed"].append("KHR_mesh_quantization")
    f.attributes["POSITION"] = f.accessor([[round(16000 * c) for c in p] for p in POSITIONS], SHORT, "VEC3")
    f.attributes["NORMAL"] = f.accessor([[round(127 * c) for c in n] for n in NORMALS], BYTE, "VEC3", normalized=True)
    f.attributes["TEXCOORD_0"] = f.accessor([[round(100 * c) for c in uv] for uv in UVS], USHORT, "VEC2")
    f.node["scale"] = [1 / 16000] * 3


def draco(f):
    view = f.view((PACKED / "dome.draco.bin").read_bytes())
    f.use("KHR_draco_mesh_compression", {"bufferView": view, "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}}, f.primitive)
    f.doc["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    for accessor in f.doc["accessors"]:
        del accessor["bufferView"]


def meshopt_view(f, index, name, stride, count, **keys):
    data = (PACKED / f"{name}.meshopt.bin").read_bytes()
    at = f.view(data)
    packed = f.doc["bufferViews"].pop(at)
    f.doc["bufferViews"][index] = {"buffer": 1, "byteLength": stride * count, "extensions": {"EXT_meshopt_compression": {
        **packed, "byteStride": stride, "count": count, **keys}}}


def meshopt(f, indices="indices", mode="TRIANGLES"):
    f.doc["extensionsUsed"].append("EXT_meshopt_compression")
    f.doc["buffers"].append({"byteLength": 9000, "extensions": {"EXT_meshopt_compression": {"fallback": True}}})
    meshopt_view(f, 0, "positions", 12, len(POSITIONS), mode="ATTRIBUTES")
    meshopt_view(f, 1, "normals", 4, len(POSITIONS), mode="ATTRIBUTES", filter="OCTAHEDRAL")
    f.doc["bufferViews"][1]["byteStride"] = 4
    f.doc["accessors"][1].update(componentType=BYTE, normalized=True)
    meshopt_view(f, 2, "uvs", 8, len(POSITIONS), mode="ATTRIBUTES", filter="EXPONENTIAL")
    meshopt_view(f, 3, indices, 2, 3 * len(TRIANGLES), mode=mode)


drawn("KHR_mesh_quantization", quantised, same(.02))
drawn("KHR_draco_mesh_compression", draco, same(.02))
drawn("EXT_meshopt_compression", meshopt, same(.02))
drawn("EXT_meshopt_compression.mode INDICES", lambda f: meshopt(f, "sequence", "INDICES"), same(.02))
refused("EXT_meshopt_compression.mode", lambda f: meshopt(f, mode="LINES"), "mode is 'LINES'")


def webp(f):
    textured(f, halves((0, 255, 0), (0, 255, 0)))
    f.doc["images"].append({"uri": data_uri((PACKED / "halves.webp").read_bytes(), "image/webp")})
    f.use("EXT_texture_webp", {"source": 1}, f.doc["textures"][0])


drawn("EXT_texture_webp.source", webp, same(.1), base=textured)
named("KHR_texture_basisu.source", lambda f: textured(f) or f.doc["images"].append({"uri": "a.ktx2"}) or f.use(
    "KHR_texture_basisu", {"source": 1}, f.doc["textures"][0]), "KHR_texture_basisu pictures (KTX2) are not read; the other picture")
named("KHR_texture_basisu (alone)", lambda f: textured(f) or f.doc["images"].__setitem__(0, {"uri": "a.ktx2"}) or f.doc["textures"][0].pop(
    "source") or f.use("KHR_texture_basisu", {"source": 0}, f.doc["textures"][0]), "the plain value is used")
