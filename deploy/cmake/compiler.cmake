# SPDX-License-Identifier: Apache-2.0
# Compiler settings shared by every target. tessera_warnings is linked PRIVATE by each of our own
# targets; -ffp-contract=off is global, since an edge test contracted by the compiler leaks.
include_directories(${CMAKE_SOURCE_DIR})
# Programs and the plug-ins that they load lie side by side, so that both find each other in the
# build tree; the install tree has its own places (deploy/cmake/install.cmake).
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
add_compile_options(-ffp-contract=off)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)

add_library(tessera_warnings INTERFACE)
target_link_libraries(tessera_warnings INTERFACE tessera_hardening)
target_compile_options(tessera_warnings INTERFACE -Wall -Wextra -Wconversion -Werror)
if(TESSERA_LOCK_ANNOTATIONS)
  target_compile_options(tessera_warnings INTERFACE -Wthread-safety)
endif()

if(TESSERA_SANITIZE)
  add_compile_options(-fsanitize=${TESSERA_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${TESSERA_SANITIZE})
  if(TESSERA_SANITIZE MATCHES "undefined")
    add_compile_options(-fno-sanitize-recover=undefined)
  endif()
  if(TESSERA_SANITIZE MATCHES "thread")
    add_compile_definitions(ASIO_DISABLE_FENCED_BLOCK)
  endif()
endif()

# libFuzzer sees by this which inputs lead to new places; without it, it has nothing to go by and ends.
if(TESSERA_LIBFUZZER)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

find_program(TESSERA_CCACHE ccache)
if(TESSERA_CCACHE)
  set(CMAKE_C_COMPILER_LAUNCHER ${TESSERA_CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${TESSERA_CCACHE})
endif()
find_program(TESSERA_MOLD mold)
if(TESSERA_MOLD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_link_options(-fuse-ld=mold)
endif()
