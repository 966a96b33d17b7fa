# SPDX-License-Identifier: Apache-2.0
# Each build runs this (cmake -P). It writes OUTPUT from INPUT with this tree's version, where that changed:
#   at a tag v1.2.3            1.2.3
#   four commits behind it     1.2.3+4.gabc1234
#   no tag in reach            PROJECT_VERSION+gabc1234
#   without git                PROJECT_VERSION
# Where files differ from the commit, ".changed" stands behind it, or "+changed" behind a tag's number.
execute_process(
  COMMAND git -C ${SOURCE} describe --tags --match "v[0-9]*" --always --dirty=.changed
  OUTPUT_VARIABLE said ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
set(TESSERA_VERSION ${PROJECT_VERSION})
if(NOT failed)
  if(said MATCHES "^v([0-9.]+)-([0-9]+)-(g[0-9a-f]+.*)$")
    set(TESSERA_VERSION "${CMAKE_MATCH_1}+${CMAKE_MATCH_2}.${CMAKE_MATCH_3}")
  elseif(said MATCHES "^v([0-9.]*[0-9])(\\.changed)?$")
    set(TESSERA_VERSION ${CMAKE_MATCH_1})
    if(CMAKE_MATCH_2)
      string(APPEND TESSERA_VERSION "+changed")
    endif()
  elseif(said MATCHES "^[0-9a-f]+(\\.changed)?$")
    string(APPEND TESSERA_VERSION "+g${said}")
  endif()
endif()
configure_file(${INPUT} ${OUTPUT} @ONLY)
