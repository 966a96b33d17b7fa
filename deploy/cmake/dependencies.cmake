# SPDX-License-Identifier: Apache-2.0
# Finds every third-party package; Debian 12 has them all. tests/tidy checks which folder may use which.
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(OpenSSL 3 REQUIRED COMPONENTS SSL Crypto)

# Asio has headers only and no CMake package.
find_path(ASIO_INCLUDE_DIR asio.hpp REQUIRED)
add_library(dep_asio INTERFACE)
target_include_directories(dep_asio SYSTEM INTERFACE ${ASIO_INCLUDE_DIR})
target_compile_definitions(dep_asio INTERFACE
  ASIO_STANDALONE ASIO_NO_DEPRECATED
  # Asio 1.22 does not recognise that clang has coroutines.
  $<$<CXX_COMPILER_ID:Clang>:ASIO_HAS_CO_AWAIT=1;ASIO_HAS_STD_COROUTINE=1>)
target_link_libraries(dep_asio INTERFACE Threads::Threads OpenSSL::SSL)

pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
find_package(Protobuf 3.21 REQUIRED MODULE)
find_package(spdlog 1.10 REQUIRED CONFIG)
find_package(hwy 1.0.3 REQUIRED CONFIG)
find_package(TBB 2021 REQUIRED CONFIG)
find_package(CLI11 REQUIRED CONFIG)
find_package(tomlplusplus REQUIRED CONFIG)

find_package(OpenImageIO 2.4 REQUIRED CONFIG)
# Debian's exported target names an opencv folder that libopenimageio-dev does not install; without
# these lines generation stops with "includes non-existent path".
set_property(TARGET OpenImageIO::OpenImageIO PROPERTY INTERFACE_INCLUDE_DIRECTORIES "")
set_property(TARGET OpenImageIO::OpenImageIO PROPERTY INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "")

find_package(glfw3 3.3 REQUIRED CONFIG)
find_package(OpenGL REQUIRED COMPONENTS OpenGL)
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)
find_package(nlohmann_json 3.11 REQUIRED CONFIG)
find_package(meshoptimizer 0.18 REQUIRED CONFIG)
find_package(draco 1.5 REQUIRED CONFIG)
find_package(assimp 5.2 REQUIRED CONFIG)

if(TESSERA_TESTS)
  find_package(GTest REQUIRED CONFIG)
  include(GoogleTest)
endif()

# Open CASCADE reads CAD files (master/import/cad); without it the plug-in is left out. Its CMake package is not used: it
# asks for X and GL, which the libraries named here do without.
find_path(OCCT_INCLUDE_DIR Standard_Version.hxx PATH_SUFFIXES opencascade)
find_library(OCCT_STEP_LIBRARY TKSTEP)
find_library(OCCT_IGES_LIBRARY TKIGES)
if(OCCT_INCLUDE_DIR AND OCCT_STEP_LIBRARY AND OCCT_IGES_LIBRARY)
  add_library(dep_occt INTERFACE)
  target_include_directories(dep_occt SYSTEM INTERFACE ${OCCT_INCLUDE_DIR})
  target_link_libraries(dep_occt INTERFACE TKSTEP TKSTEPBase TKSTEPAttr TKSTEP209 TKIGES TKXSBase TKShHealing TKTopAlgo
    TKGeomAlgo TKBRep TKGeomBase TKG3d TKG2d TKMath TKernel)
else()
  message(STATUS "no Open CASCADE (libocct-data-exchange-dev): CAD files are not read")
endif()
