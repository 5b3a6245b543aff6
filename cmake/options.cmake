# Every target of ours is built with `seaway_options`, which nobody inherits, and passes on
# `seaway_headers`: what a program needs that includes our headers, and no flag more.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
# Line tables are enough for stack traces and build far faster than full debug information.
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1")
set(CMAKE_CXX_FLAGS_RELEASE "-O2")
if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
  if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
  endif()
endif()

# Programs and tests are a hundred links, each a second with the linker that compilers take by themselves.
find_program(SEAWAY_LLD ld.lld)
if(PROJECT_IS_TOP_LEVEL AND SEAWAY_LLD)
  add_link_options(-fuse-ld=lld)
endif()

# Each version of a compiler finds new things to warn of. g++ 12 judges, where Seaway itself is built.
set(judged OFF)
if(PROJECT_IS_TOP_LEVEL AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU"
    AND CMAKE_CXX_COMPILER_VERSION MATCHES "^12\\.")
  set(judged ON)
endif()
option(SEAWAY_WERROR "Warnings are errors" ${judged})

find_package(fmt REQUIRED) # every room may use it
add_library(seaway_headers INTERFACE)
target_compile_features(seaway_headers INTERFACE cxx_std_20)
target_include_directories(seaway_headers INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
target_compile_definitions(seaway_headers INTERFACE SEAWAY_VERSION="${PROJECT_VERSION}")
target_link_libraries(seaway_headers INTERFACE fmt::fmt)

add_library(seaway_options INTERFACE)
# Contraction off: the realised sea and the codec are the same bits with every compiler and level.
# What designated initialisers leave out is zero on purpose.
target_compile_options(seaway_options INTERFACE -ffp-contract=off -Wall -Wextra -Wpedantic
  $<$<NOT:$<BOOL:$<TARGET_PROPERTY:SEAWAY_SHADOWS>>>:-Wshadow> -Wnon-virtual-dtor -Wcast-align -Wold-style-cast -Woverloaded-virtual
  -Wno-missing-field-initializers -Werror=switch)
# The same objects make programs, tests and libseaway.so: nothing is compiled twice. What is hidden is called and
# read as in a program (docs/decisions/0046-packages.md has the cost).
target_compile_options(seaway_options INTERFACE -fPIC -fvisibility=hidden
  $<$<COMPILE_LANGUAGE:CXX>:-fvisibility-inlines-hidden>)
# GCC collects garbage in what it holds while it compiles, a tenth of its time; up to 512 MB of it may lie.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(seaway_options INTERFACE --param=ggc-min-heapsize=524288)
endif()
# Kernels for AVX2 and AVX-512 are built, and taken where the machine has them. Fuzzers do with those for any machine: what
# somebody sends has become numbers before a kernel sees it, and instrumented ones are a quarter of what clang takes.
if(NOT SEAWAY_FUZZ)
  string(REGEX MATCH "x86_64|AMD64" SEAWAY_X86 "${CMAKE_SYSTEM_PROCESSOR}")
endif()
if(SEAWAY_X86)
  target_compile_definitions(seaway_options INTERFACE SEAWAY_X86)
endif()
if(SEAWAY_SANITIZE)
  # Instrumented code confuses GCC's flow analysis (array bounds, uninitialised values); other builds
  # judge warnings.
  target_compile_options(seaway_options INTERFACE -fsanitize=${SEAWAY_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(seaway_options INTERFACE -fsanitize=${SEAWAY_SANITIZE})
elseif(SEAWAY_WERROR)
  # What GCC 12 concludes from following values through inlined strings is at times false, and depends
  # on the length of the folder's path: that is told, not refused.
  target_compile_options(seaway_options INTERFACE -Werror -Wno-error=array-bounds
    -Wno-error=restrict -Wno-error=stringop-overflow -Wno-error=stringop-overread
    -Wno-error=maybe-uninitialized)
endif()
if(SEAWAY_FUZZ)
  # A third of what clang takes goes to looks at each pointer before it is used. What they would find ends the process at
  # once, or is AddressSanitizer's; the preset `asan` has them, for the corpora too.
  target_compile_options(seaway_options INTERFACE -fsanitize=fuzzer-no-link
    -fno-sanitize=alignment,null,object-size,vptr)
endif()

# What most sources include of the standard library is a third of what they take to compile: once for all
# of them. Not below a launcher: ccache keeps nothing that was compiled with a precompiled header.
set(precompile OFF)
if(PROJECT_IS_TOP_LEVEL AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(precompile ON)
endif()
option(SEAWAY_PRECOMPILE "Compile common headers once, and tests some files at a time" ${precompile})
if(SEAWAY_PRECOMPILE)
  add_library(seaway_common_headers OBJECT ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
  target_link_libraries(seaway_common_headers PRIVATE seaway_headers seaway_options)
  target_precompile_headers(seaway_common_headers PRIVATE <algorithm> <array> <chrono> <cmath> <functional>
    <map> <memory> <mutex> <optional> <span> <string> <string_view> <utility> <vector> <fmt/format.h>)
endif()
