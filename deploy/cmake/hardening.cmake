# SPDX-License-Identifier: Apache-2.0
# What makes a memory error in a program end it, instead of being of use to who caused it. Each target of ours gets it
# by way of tessera_warnings; tests/deploy/hardening_test.py looks at what was built.
#
# The ray kernels (TESSERA_KERNELS) and tests (TESSERA_IS_TEST) have the linker's part alone: kernels read no byte from
# a peer or a file, and are the one place where a check for each function would be felt.
# All code is position independent already (CMAKE_POSITION_INDEPENDENT_CODE).
add_link_options(LINKER:-z,relro,-z,now,-z,noexecstack $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-pie>)

define_property(TARGET PROPERTY TESSERA_IS_TEST INITIALIZE_FROM_VARIABLE DEFAULT_TESSERA_IS_TEST)
set(hardening -fstack-protector-strong -fstack-clash-protection -fcf-protection=full)
set(spared $<OR:$<BOOL:$<TARGET_PROPERTY:TESSERA_KERNELS>>,$<BOOL:$<TARGET_PROPERTY:TESSERA_IS_TEST>>>)
add_library(tessera_hardening INTERFACE)
target_compile_options(tessera_hardening INTERFACE "$<$<NOT:${spared}>:${hardening}>")
# Checked variants of memcpy() and others need an optimiser, and blind the address sanitizer.
if(NOT TESSERA_SANITIZE)
  set(fortified $<AND:$<NOT:${spared}>,$<CONFIG:Release,RelWithDebInfo>>)
  target_compile_options(tessera_hardening INTERFACE "$<${fortified}:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=3>")
endif()
