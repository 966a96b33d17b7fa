# SPDX-License-Identifier: Apache-2.0
# What makes a memory error in a program end it, instead of being of use to who caused it. Each target of ours gets it
# by way of tessera_warnings; tests/deploy/hardening_test.py looks at what was built.
#
# The ray core (TESSERA_KERNELS) and tests (TESSERA_IS_TEST) have the linker's part alone: the core reads no byte from a
# peer or a file, and its kernels feel the flags. With all of them, and without the stack protector, too, the kernel of
# nearest hits takes more instructions than a feature may cost (bench_feature_cost): decisions/hardened-kernels.md.
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
