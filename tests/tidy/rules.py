# SPDX-License-Identifier: Apache-2.0
"""The rules as tables: which folder may include which, where each library may be named, limits.

tests/tidy/README.md says why; check_sources.py applies them.
"""

FILE_LINES_MAX = 400
FUNCTION_LINES_MAX = 70
HEADER_COMMENT_LINES_MIN = 2

# Folder -> folders whose headers it may include, besides its own. The longest matching key rules
# a file; folders that have no key may not exist. tests/ may include everything.
_BASE = ["common/base"]
_VALUES = _BASE + ["common/math", "common/scene", "common/frame"]
_COMMON = _VALUES + ["common/metrics", "common/net"]
_CORE = "slave/core/"
# The rooms of the core, each above those that it names (slave/core/README.md has the picture).
_TRIANGLE = _CORE + "primitive/triangle"


def _rooms(names):
    return _VALUES + [_CORE + name for name in names.split()]


_STAGES = ["master/image", "master/schedule"]
_CLUSTER = _STAGES + ["master/cluster"]
_FRAMES = _CLUSTER + ["master/loader", "master/display", "master/frame_loop"]

ARROWS = {
    "proto": [],
    "common/base": [],
    "common/math": _BASE,
    "common/metrics": _BASE,
    "common/scene": _BASE + ["common/math", "common/metrics"],
    "common/viewpoint": _BASE + ["common/math", "common/scene"],
    "common/frame": _BASE + ["common/math", "common/metrics", "common/scene"],
    "common/net": _BASE + ["common/metrics"],
    "common/wire": _COMMON + ["proto"],
    "common/scene_io": _BASE + ["common/math", "common/scene"],
    _CORE + "simd": _VALUES,
    _CORE + "sampling": _rooms("simd"),
    _CORE + "accel": _VALUES,
    _CORE + "ray": _rooms("simd accel"),
    _TRIANGLE: _rooms("simd accel ray surface"),
    # A ray and a sub-patch: no room of structures or packets is known there.
    _CORE + "primitive/patch": _rooms("simd"),
    # This room joins all kinds of primitives, for those who need not know which.
    _CORE + "primitive": _rooms("accel ray primitive/triangle primitive/patch"),
    _CORE + "traverse": _rooms("simd accel ray primitive"),
    # What is in an instance is traversed as a scene is.
    _CORE + "primitive/instance": _rooms("simd accel ray primitive primitive/triangle traverse"),
    # Patches of a scene in leaves.
    _CORE + "primitive/freeform": _rooms(
        "simd accel ray primitive primitive/triangle primitive/patch surface"),
    # Surfaces of patches that stand in several places: patches in leaves, and rays in object space.
    _CORE + "primitive/placed": _rooms(
        "simd accel ray primitive primitive/triangle primitive/instance primitive/patch "
        "primitive/freeform traverse"),
    _CORE + "camera": _rooms("sampling ray"),
    # surface says what a surface is, bsdf how it scatters light: neither knows of traversal.
    _CORE + "surface": _rooms("simd sampling ray"),
    _CORE + "bsdf": _rooms("simd sampling surface"),
    # Lamps are triangles or patches and may have pictures.
    _CORE + "light": _rooms(
        "simd sampling ray primitive/triangle primitive/patch primitive/freeform surface"),
    # This room has all that is compiled once per instruction set.
    _CORE + "kernels": _rooms(
        "simd sampling ray primitive primitive/triangle primitive/instance primitive/patch "
        "primitive/freeform primitive/placed traverse camera surface bsdf light"),
    _CORE + "trace": _rooms("sampling accel ray primitive primitive/triangle primitive/patch primitive/freeform surface kernels"),
    _CORE + "scene": _rooms("simd sampling accel ray primitive primitive/triangle primitive/instance primitive/patch primitive/freeform primitive/placed surface bsdf light kernels trace"),
    _CORE + "integrate": _rooms("simd sampling ray camera surface bsdf light kernels trace scene"),
    # Two rooms of the core are its door: integrate, which renders, and scene, which is rendered.
    "slave": _COMMON + ["common/wire", "proto", _CORE + "integrate", _CORE + "scene"],
    "slave/tools": _VALUES + ["common/scene_io", _CORE + "integrate", _CORE + "scene"],
    "master/image": _COMMON,
    "master/schedule": _COMMON,
    "master/cluster": _COMMON + ["common/wire", "proto", "master/schedule"],
    "master/import": _VALUES + ["common/scene_io", "master/image"],
    # The loader asks common/scene_io which formats there are, and reads no file by it.
    "master/loader": _COMMON + _CLUSTER + ["common/scene_io"],
    "master/display": _COMMON + _CLUSTER,
    # An application's connection to a running master speaks the wire's language, too.
    "master/frame_loop": _COMMON + ["common/wire"] + _CLUSTER,
    # The in-process slave is the one place where the master knows slave/.
    "master/session": _COMMON + ["common/wire", "slave", _CORE + "integrate", _CORE + "scene"] + _FRAMES,
    "master/look": _COMMON + ["master/session"],
    # The commands read camera files by common/scene_io, which are small text and no scene.
    "master/commands": _COMMON + ["common/scene_io", "common/viewpoint", "master/look", "master/session"] + _FRAMES,
    "master": ["master/commands"],
    "deploy/keys": _COMMON,
}

# Library -> (pattern of its includes, files or folders that may have them). Patterns match
# the start of the included name; a place that ends in "/" is a folder. tests/ are free, except for spdlog.
CONFINED = {
    "spdlog": (["spdlog/"], ["common/base/log.cpp"]),
    "Asio": (["asio.hpp", "asio/"], ["common/net/"]),
    "OpenSSL": (["openssl/"], ["common/net/", "common/base/digest.cpp", "deploy/keys/"]),
    "Protocol Buffers": (["google/protobuf/", "proto/"], ["common/wire/", "proto/"]),
    "compression": (["zstd.h", "lz4", "blosc"], ["common/wire/"]),
    "OpenImageIO": (["OpenImageIO/"], ["master/image/"]),
    "Assimp": (["assimp/"], ["master/import/assimp/"]),
    "Open CASCADE": (["BRep", "Geom", "IGES", "Interface_", "Message", "Quantity_", "STEP", "Shape", "Standard_", "Step",
                      "TCol", "Top", "Transfer", "XSControl_", "gp_", "Bnd_", "IFSelect_"], ["master/import/cad/"]),
    "nlohmann JSON": (["nlohmann/json.hpp"], ["master/import/gltf/document.cpp", "master/import/gltf/object.cpp"]),
    "nlohmann JSON, names only": (["nlohmann/json_fwd.hpp"], ["master/import/gltf/object.h"]),
    "Draco": (["draco/"], ["master/import/gltf/draco_mesh.cpp"]),
    "meshoptimizer": (["meshoptimizer.h"], ["master/import/gltf/meshopt_view.cpp"]),
    "GLFW": (["GLFW/"], ["master/display/"]),
    "OpenGL": (["epoxy/", "GL/"], ["master/display/"]),
    "ImGui": (["imgui"], ["master/display/"]),
    "Highway": (["hwy/"], ["slave/core/simd/", "slave/core/kernels/"]),
    "TBB": (["tbb/", "oneapi/"], ["slave/core/accel/"]),
    "toml++": (["toml++/"], ["master/commands/", "slave/"]),
}
# One file per folder at most may include these, since a second one is slow to compile, too.
ONE_FILE_PER_FOLDER = {"GLFW": ["GLFW/"], "OpenGL": ["epoxy/"], "CLI11": ["CLI/"], "toml++": ["toml++/"]}

# What files that are compiled once per instruction set may include.
# _abi.h: declarations of functions that are compiled once. _text.h: templates that are included within a
# namespace, once for each. plain.h: what real-inl.h is where a text is compiled for plain numbers.
INL_MAY_INCLUDE = [r"hwy/", r".*-inl\.h$", r".*_layout\.h$", r".*_abi\.h$", r".*_text\.h$", r"slave/core/simd/plain\.h$"]
# What a header or source for plain numbers says before it includes an -inl.h (slave/core/simd/real-inl.h).
PLAIN_TEXT = "#define TESSERA_PLAIN_TEXT"
# Namespaces of what is compiled once per instruction set, with what stands before and behind them.
LANE_NAMESPACES = {"HWY_NAMESPACE": ("HWY_BEFORE_NAMESPACE();", "HWY_AFTER_NAMESPACE();"),
                   "TESSERA_TEXT": ("TESSERA_BEFORE_TEXT();", "TESSERA_AFTER_TEXT();")}
# Rooms whose lane code is written with operators and the functions of real-inl.h alone.
WITHOUT_HIGHWAYS_NAMES = [_CORE + room for room in ("sampling/", "camera/", "surface/", "bsdf/", "light/")]
C_HEADERS = {"stddef.h", "stdint.h", "string.h", "math.h", "float.h", "limits.h", "stdbool.h"}

# Words, and the folders that know nothing of what they mean.
STRANGERS = {"triangle": [_CORE + "accel/", _CORE + "ray/", _CORE + "traverse/"]}

# Roots of paths that belong to one machine; a source that names one runs only there.
MACHINE_PATHS = ["work", "home", "root", "Users", "mnt"]

# The first line of each source, or the second where the first says who runs it.
LICENCE_LINE = "SPDX-License-Identifier: Apache-2.0"

# Tests that neither sleep nor open sockets: what needs either has tests/links or virtual time (tests/sim).
STILL_TESTS = ["tests/unit/", "tests/property/"]
STILL_MAY_NOT = ["sleep_for", "sleep_until", "usleep(", "common/net/io_thread.h", "common/net/local_pair.h",
                 "tests/support/net_peer.h", "sys/socket.h"]

# A folder's README is a map. Rows of tables cannot be wrapped.
README_LINES_MAX, README_COLUMNS_MAX = 120, 100
COMMENT_COLUMNS_MAX = 100  # of C++, whose code clang-format breaks
