# SPDX-License-Identifier: Apache-2.0
# What makes a memory error in a program end it, instead of being of use to who caused it. Each target of ours gets it
# by way of tessera_warnings; tests/deploy/hardening_test.py looks at what was built.
#
# Tests (TESSERA_IS_TEST) have the linker's part alone. What the flags cost the kernels stands in
# decisions/hardened-kernels.md. Under the address sanitizer the ray core (TESSERA_KERNELS) has no stack protector:
# together the two make gcc 12 misalign objects of 64 bytes, and the sanitizer finds more than the protector does.
# All code is position independent already (CMAKE_POSITION_INDEPENDENT_CODE).
add_link_options(LINKER:-z,relro,-z,now,-z,noexecstack $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-pie>)

define_property(TARGET PROPERTY TESSERA_IS_TEST INITIALIZE_FROM_VARIABLE DEFAULT_TESSERA_IS_TEST)
set(is_test $<BOOL:$<TARGET_PROPERTY:TESSERA_IS_TEST>>)
set(unprotected ${is_test})
if(TESSERA_SANITIZE MATCHES "address")
  set(unprotected $<OR:${is_test},$<BOOL:$<TARGET_PROPERTY:TESSERA_KERNELS>>>)
endif()
add_library(tessera_hardening INTERFACE)
target_compile_options(tessera_hardening INTERFACE
  "$<$<NOT:${unprotected}>:-fstack-protector-strong>"
  "$<$<NOT:${is_test}>:-fstack-clash-protection;-fcf-protection=full>")
# Checked variants of memcpy() and others need an optimiser, and blind the address sanitizer.
if(NOT TESSERA_SANITIZE)
  set(fortified $<AND:$<NOT:${is_test}>,$<CONFIG:Release,RelWithDebInfo>>)
  target_compile_options(tessera_hardening INTERFACE "$<${fortified}:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=3>")
endif()
