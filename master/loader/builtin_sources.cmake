# SPDX-License-Identifier: Apache-2.0
# Sources of the built-in scenes.
set(TESSERA_BUILTIN_SOURCES builtin.cpp builtin_fields.cpp builtin_paint.cpp builtin_room.cpp builtin_teapot.cpp mesh_maker.cpp)
