# Every target of ours links `seaway_options`.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()
# Line tables are enough for stack traces and build far faster than full debug information.
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1")
set(CMAKE_CXX_FLAGS_RELEASE "-O2")

add_library(seaway_options INTERFACE)
target_include_directories(seaway_options INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
# Contraction off: the realised sea and the codec are the same bits with every compiler and level.
target_compile_options(seaway_options INTERFACE -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow
  -Wnon-virtual-dtor -Wcast-align -Wold-style-cast -Woverloaded-virtual -Werror)
target_compile_definitions(seaway_options INTERFACE SEAWAY_VERSION="${PROJECT_VERSION}")
# Kernels for AVX2 and AVX-512 are built, and taken where the machine has them.
string(REGEX MATCH "x86_64|AMD64" SEAWAY_X86 "${CMAKE_SYSTEM_PROCESSOR}")
if(SEAWAY_X86)
  target_compile_definitions(seaway_options INTERFACE SEAWAY_X86)
endif()
if(SEAWAY_SANITIZE)
  # Instrumented code confuses GCC's flow analysis (array bounds, uninitialised values); other builds
  # judge warnings.
  target_compile_options(seaway_options INTERFACE -Wno-error)
  target_compile_options(seaway_options INTERFACE -fsanitize=${SEAWAY_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(seaway_options INTERFACE -fsanitize=${SEAWAY_SANITIZE})
endif()
if(SEAWAY_FUZZ)
  target_compile_options(seaway_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
