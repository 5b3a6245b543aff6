# Writes which commit is being built into a header, for figures that say what they are of: anew at each build, so that no cache
# knows an older one, and only where it has changed.
#     cmake -D SOURCE=folder -D HEADER=file -P commit.cmake
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(NOT failed EQUAL 0)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT "// SPDX-License-Identifier: Apache-2.0
#pragma once
#define SEAWAY_COMMIT \"${commit}\"
")
