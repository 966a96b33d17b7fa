# SPDX-License-Identifier: Apache-2.0
cmake_minimum_required(VERSION 3.25)
project(app LANGUAGES CXX)
find_package(tessera REQUIRED)
add_executable(app app.cpp)
target_link_libraries(app PRIVATE tessera::tessera)
