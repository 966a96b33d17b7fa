# SPDX-License-Identifier: Apache-2.0
# The slave node is a library, since a master's process may hold some; the daemon holds one.
add_library(tessera_slave STATIC
  build_order.cpp build_pace.cpp master_link.cpp paced_gate.cpp pixel_coder.cpp
  relay_child.cpp relay_feeder.cpp
  render_service.cpp scene_builder.cpp scene_intake.cpp scene_preparation.cpp slave_host.cpp slave_metrics.cpp
  slave_node.cpp tile_queue.cpp)
target_link_libraries(tessera_slave
  PUBLIC tessera_base tessera_metrics tessera_scene tessera_frame tessera_net tessera_wire
    tessera_core
  PRIVATE tessera_warnings tessera_version)

add_executable(tessera-slave main.cpp slave_cli.cpp)
target_link_libraries(tessera-slave PRIVATE tessera_warnings tessera_version tessera_slave CLI11::CLI11)
install(TARGETS tessera-slave RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

add_subdirectory(tools)
