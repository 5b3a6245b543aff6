# seaway_precompiled(TARGET HEADERS): the target includes what the target HEADERS has precompiled.
function(seaway_precompiled target headers)
  if(SEAWAY_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${headers})
  endif()
endfunction()

# seaway_source_options(OPTIONS source.cpp ...): options of single sources, a list. What was precompiled with
# others is refused, so they do without.
function(seaway_source_options options)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "${options}" SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# Sixteen files are compiled as one, in less than half the time: most of it goes to headers that all of them take.
# So no two files of a room or program may give one name, outside functions, to different things.
function(seaway_together target)
  if(SEAWAY_PRECOMPILE)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
  endif()
endfunction()

# seaway_room(NAME SOURCES a.cpp ... COLD b.cpp ... LINKS lib ...): a room's static library, `seaway_NAME`. COLD: templates
# of libraries, mostly, that run once or wait for the system: optimising them wins nothing and takes half of their time.
function(seaway_room name)
  cmake_parse_arguments(R "" "" "SOURCES;COLD;LINKS" ${ARGN})
  add_library(seaway_${name} STATIC ${R_SOURCES})
  if(R_COLD)
    add_library(seaway_${name}_cold OBJECT ${R_COLD})
    target_link_libraries(seaway_${name}_cold PRIVATE seaway_headers seaway_options ${R_LINKS})
    target_compile_options(seaway_${name}_cold PRIVATE -O1 -g0)
    seaway_together(seaway_${name}_cold)
    target_sources(seaway_${name} PRIVATE $<TARGET_OBJECTS:seaway_${name}_cold>)
  endif()
  target_link_libraries(seaway_${name} PUBLIC seaway_headers ${R_LINKS} PRIVATE seaway_options)
  seaway_precompiled(seaway_${name} seaway_common_headers)
  seaway_together(seaway_${name})
endfunction()

# seaway_program(seaway-query SOURCES main.cpp LINKS seaway_client): a program in build/<preset>/bin.
function(seaway_program name)
  cmake_parse_arguments(P "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${P_SOURCES})
  target_link_libraries(${name} PRIVATE seaway_headers seaway_options ${P_LINKS})
  seaway_precompiled(${name} seaway_common_headers)
  seaway_together(${name})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()

# seaway_test(sea SOURCES test_x.cpp ... LINKS ...): one GoogleTest program a room, one ctest entry.
# Tests read their data below SEAWAY_SOURCE_DIR and find programs in SEAWAY_BIN_DIR. DRIVER: a Vulkan
# driver is loaded, here or in a program that is started. What is tested is optimised in its own
# library; the tests around it compile a sixth faster at -O1 (docs/decisions/0023), and those that wait in half of the time at
# -O0. The time limit ends what hangs, and nothing else: it is half an hour, since a machine that is slow, or has others to serve,
# takes many times as long as one that has not, and what goes on has not failed.
# `dev` gives out six places, for two cores: two to each, as one thread takes it, one to what WAITS for most of its time, four to
# what has BOTH_CORES busy with threads of its own. LONG: more than half a minute, so it begins early, and nothing waits for it alone
# at the end.
function(seaway_test name)
  cmake_parse_arguments(T "DRIVER;WAITS;BOTH_CORES;LONG" "TIMEOUT" "SOURCES;LINKS" ${ARGN})
  if(NOT T_TIMEOUT)
    set(T_TIMEOUT 1800)
  endif()
  add_executable(test_${name} ${T_SOURCES})
  target_link_libraries(test_${name} PRIVATE seaway_headers seaway_options
    ${T_LINKS} GTest::gmock GTest::gtest_main)
  set(level 1)
  if(T_WAITS AND NOT SEAWAY_SANITIZE)
    set(level 0)
  endif()
  target_compile_options(test_${name} PRIVATE -O${level})
  # Tests that are compiled together shadow each other's names at their ease.
  set_target_properties(test_${name} PROPERTIES SEAWAY_SHADOWS ON)
  seaway_precompiled(test_${name} seaway_test_headers_o${level})
  seaway_together(test_${name})
  target_compile_definitions(test_${name} PRIVATE SEAWAY_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    SEAWAY_BIN_DIR="${PROJECT_BINARY_DIR}/bin")
  add_test(NAME ${name} COMMAND test_${name} --gtest_brief=1)
  set_tests_properties(${name} PROPERTIES TIMEOUT ${T_TIMEOUT})
  set(cost 0)
  set(places 2)
  if(T_LONG)
    math(EXPR cost "${cost} + 100")
  endif()
  if(T_WAITS)
    set(places 1)
  endif()
  if(T_BOTH_CORES) # one after the other: behind others they would wait until four places are free at once
    math(EXPR cost "${cost} + 200")
    set(places 4)
  endif()
  set_tests_properties(${name} PROPERTIES PROCESSORS ${places})
  if(cost)
    set_tests_properties(${name} PROPERTIES COST ${cost})
  endif()
  if(T_DRIVER)
    set(driver DRIVER)
  endif()
  seaway_sanitized_test(${name} ${driver})
endfunction()

# seaway_sanitized_test(NAME [DRIVER]): what a test needs to run with sanitizers; DRIVER: it, or a program that it starts, opens a device.
function(seaway_sanitized_test name)
  if(SEAWAY_SANITIZE MATCHES address AND "DRIVER" IN_LIST ARGN)
    # lavapipe's compiler (LLVM) leaks some KB when it is unloaded.
    set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT ASAN_OPTIONS=detect_leaks=0)
  endif()
  if(SEAWAY_SANITIZE MATCHES thread)
    set_property(TEST ${name} APPEND PROPERTY
      ENVIRONMENT TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/tsan.supp)
    get_test_property(${name} TIMEOUT timeout) # all of it takes some ten times as long
    math(EXPR timeout "4 * ${timeout}")
    set_tests_properties(${name} PROPERTIES TIMEOUT ${timeout})
  endif()
endfunction()

# seaway_loops(ROOM NAME [SAME_BITS] [AVX512]): NAME_portable.cpp and, on x86, NAME_avx2.cpp (and NAME_avx512.cpp) of a room:
# loops over whole grids, one source compiled once per instruction set; the values differ by rounding, or SAME_BITS.
function(seaway_loops room name)
  cmake_parse_arguments(L "SAME_BITS;AVX512" "" "" ${ARGN})
  set(contract $<IF:$<BOOL:${L_SAME_BITS}>,off,fast>)
  set(loop_options "-O3;-ffp-contract=${contract};-fno-math-errno;-fno-trapping-math;-Wno-psabi")
  target_sources(seaway_${room} PRIVATE ${name}_portable.cpp)
  seaway_source_options("${loop_options}" ${name}_portable.cpp)
  if(SEAWAY_X86)
    target_sources(seaway_${room} PRIVATE ${name}_avx2.cpp)
    seaway_source_options("${loop_options};-mavx2;-mfma" ${name}_avx2.cpp)
    if(L_AVX512)
      target_sources(seaway_${room} PRIVATE ${name}_avx512.cpp)
      seaway_source_options("${loop_options};-mavx512f;-mavx512dq;-mavx512vl;-mfma;-mprefer-vector-width=512" ${name}_avx512.cpp)
    endif()
  endif()
endfunction()
