# Compiler settings and the small functions that every folder's CMakeLists.txt uses.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Dev CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_FLAGS_DEV "-O2 -g1")
set(CMAKE_CXX_FLAGS_SANITIZE "-O1 -g1 -fno-omit-frame-pointer")
set(CMAKE_EXE_LINKER_FLAGS_DEV "")
set(CMAKE_EXE_LINKER_FLAGS_SANITIZE "")
# Programs of two fifths of the size. Not zstd: neither lld 14 nor what symbolises the sanitizers' reports knows it.
set(compressed -Wl,--compress-debug-sections=zlib)
add_link_options("$<$<CONFIG:Dev,Sanitize>:${compressed}>")

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  # Paths below the tree are told to the cache as relative ones, so that a clone elsewhere finds what another compiled.
  set(cache_settings CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1)
  if(SANSO_PRECOMPILED)  # what the cache has to be told, and gcc, so that it sees through a precompiled header
    list(APPEND cache_settings CCACHE_SLOPPINESS=pch_defines,time_macros)
    add_compile_options($<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  endif()
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env ${cache_settings} ${CCACHE_PROGRAM})
endif()

add_compile_options(-Wall -Wextra -Wpedantic -Wshadow -Wno-unknown-warning-option)
# gcc 12 reports false positives of these inside Eigen and the standard library when it inlines deeply.
add_compile_options(-Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
add_compile_options($<$<CONFIG:Release>:-Wno-restrict>)
# The same source must give the same bits in every build: no contraction differences between call sites.
add_compile_options(-ffp-contract=off)
if(SANSO_WERROR)
  add_compile_options(-Werror)
endif()
if(SANSO_SANITIZE)
  add_compile_options(-fsanitize=${SANSO_SANITIZE} -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${SANSO_SANITIZE})
  if(SANSO_SANITIZE MATCHES "address,undefined")
    # What an access through a null pointer or beyond an object does, the address sanitizer says too. Asked twice, a
    # source full of Eigen took up to twice as long to compile.
    add_compile_options(-fno-sanitize=null,object-size)
  endif()
endif()

# Tests are compiled more than they are run: the code under test is optimised, they are a little.
set(SANSO_TEST_OPTIMISATION)
if(CMAKE_BUILD_TYPE STREQUAL Dev)
  set(SANSO_TEST_OPTIMISATION -O1)
endif()

# Half of the time of a sanitized build went into checks of what tests of host and tools do themselves. The code under
# test keeps them all; tests of what reads bytes (firmware, shared, fuzz, loop) too.
set(SANSO_UNCHECKED)
if(SANSO_SANITIZE MATCHES undefined AND CMAKE_CXX_COMPILER_ID STREQUAL Clang)
  set(SANSO_UNCHECKED -fno-sanitize=undefined)
endif()

# Whether an address is aligned is asked where bytes are read in place (firmware, shared, what comes with recordings and
# motions); rooms that calculate on containers have it right by type, and asking there took a sixth of their time.
set(SANSO_ALIGNED_BY_TYPE)
set(calculating "tools/diagnose/(compare|effects|explain|fit|sim|stats|torque|verdict|wholebody|run)")
if(SANSO_UNCHECKED)
  set(SANSO_ALIGNED_BY_TYPE -fno-sanitize=alignment)
endif()

# Tests and fuzz targets are linked in a third of the time where lld is there (two programs: 4.4 s of processor time, 1.3 s
# with it); what is delivered is linked as its packages will be.
find_program(SANSO_LLD ld.lld)
set(SANSO_TEST_LINKER)
if(SANSO_LLD AND NOT CMAKE_CROSSCOMPILING)  # a cross compiler looks for its own
  set(SANSO_TEST_LINKER -fuse-ld=lld)
endif()

find_package(Eigen3 QUIET NO_MODULE)
if(NOT TARGET Eigen3::Eigen)  # cross builds: headers only, architecture-free
  add_library(Eigen3::Eigen INTERFACE IMPORTED)
  target_include_directories(Eigen3::Eigen SYSTEM INTERFACE /usr/include/eigen3)
endif()
find_package(Threads REQUIRED)  # the board's build has threads too
if(NOT SANSO_FIRMWARE_ONLY)
  find_package(PkgConfig REQUIRED)
endif()

# MuJoCo by hand: the config file that Debian ships names an include folder that its packages do not install.
if(NOT SANSO_FIRMWARE_ONLY AND NOT TARGET sanso_mujoco)
  find_library(MUJOCO_LIBRARY mujoco REQUIRED)
  add_library(sanso_mujoco INTERFACE)
  target_link_libraries(sanso_mujoco INTERFACE ${MUJOCO_LIBRARY})
endif()

# sanso_library(name SOURCES ... LINK ... [PRIVATE_LINK ...]): header-only when SOURCES is empty.
# Includes are always written from the top of the tree: #include "shared/base/status.h".
function(sanso_library name)
  cmake_parse_arguments(A "" "" "SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  if(A_SOURCES)
    add_library(${name} STATIC ${A_SOURCES})
    target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} PUBLIC ${A_LINK} PRIVATE ${A_PRIVATE_LINK})
    set_property(GLOBAL APPEND PROPERTY SANSO_LIBRARIES ${name})
    cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE room)
    if(SANSO_ALIGNED_BY_TYPE AND room MATCHES "^(host/(learn|mpc)|tools/(bench|conceal|plant|sweep)|${calculating})")
      target_compile_options(${name} PRIVATE ${SANSO_ALIGNED_BY_TYPE})
    endif()
  else()
    add_library(${name} INTERFACE)
    target_include_directories(${name} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} INTERFACE ${A_LINK})
  endif()
endfunction()

set(SANSO_NUMBERS compare effects explain fit run stats torque verdict wholebody)
list(TRANSFORM SANSO_NUMBERS PREPEND tests/tools/diagnose/)
list(APPEND SANSO_NUMBERS tests/tools/bench_diagnose tests/tools/conceal)
# sanso_test(name SOURCES ... LINK ... [LABELS ...] [TIMEOUT s] [COST s]): one GoogleTest program, one ctest entry.
# Labels: slow (left out under sanitizers), threads (run under the thread sanitizer), tree (reads the sources, runs none
# of them, so that one run is enough).
# numbers (below): arithmetic on containers of values, without bytes, threads or pointers of its own, and the commands that
# need all of it; the largest part of a build under sanitizers. `cmake --build build/asan-ubsan && ctest --preset asan-ubsan -L numbers` runs them as well.
add_custom_target(threaded_tests)
add_custom_target(sanitized_tests)
function(sanso_test name)
  cmake_parse_arguments(A "" "TIMEOUT;COST" "SOURCES;LINK;LABELS" ${ARGN})
  if(NOT TARGET GTest::gtest)
    find_package(GTest REQUIRED)
  endif()
  add_executable(${name} ${A_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${A_LINK} GTest::gtest GTest::gmock GTest::gtest_main)
  target_link_options(${name} PRIVATE ${SANSO_TEST_LINKER})
  target_compile_options(${name} PRIVATE ${SANSO_TEST_OPTIMISATION})
  if(NOT A_TIMEOUT)
    set(A_TIMEOUT 1500)  # ends what hangs, not what is slow: a crowded machine may take twenty times as long as a quiet one
  endif()
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${A_TIMEOUT} LABELS "${A_LABELS}"
    ENVIRONMENT MALLOC_PERTURB_=128)  # memory nobody wrote reads as 1.4e306 in glibc, on every machine alike
  if(NOT A_COST AND "slow" IN_LIST A_LABELS)
    set(A_COST 100)
  endif()
  if(A_COST)
    set_tests_properties(${name} PROPERTIES COST ${A_COST})  # the longest begin first, so that none is left over alone
  endif()
  if("threads" IN_LIST A_LABELS)  # what the build preset tsan builds
    add_dependencies(threaded_tests ${name})
  endif()
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE room)
  if(SANSO_UNCHECKED AND room MATCHES "^tests/(host|tools)/")
    target_compile_options(${name} PRIVATE ${SANSO_UNCHECKED})
    set_property(GLOBAL APPEND PROPERTY SANSO_TESTS_OF_VALUES ${name})
  else()
    set_property(GLOBAL APPEND PROPERTY SANSO_TESTS ${name})
  endif()
  if(room IN_LIST SANSO_NUMBERS)
    set_property(TEST ${name} APPEND PROPERTY LABELS numbers)
  elseif(NOT "slow" IN_LIST A_LABELS)  # what the build preset asan-ubsan builds
    add_dependencies(sanitized_tests ${name})
  endif()
endfunction()

# sanso_fuzz(name source LINK ...): a libFuzzer target, built only under -DSANSO_FUZZ=ON (preset asan-ubsan). Where it has a
# folder in tests/fuzz/corpus, what it finds there is replayed by fuzz_corpus_test, in every build: ${name}_replay.
# Coverage of the code under test guides a fuzzer: libraries that it links have it (SansoFuzzed.cmake), no others,
# because it makes them slower in every test.
set(SANSO_COVERAGE -fsanitize=fuzzer-no-link)
add_custom_target(fuzzers)
function(sanso_fuzz name source)
  cmake_parse_arguments(A "" "" "LINK" ${ARGN})
  if(SANSO_FUZZ)
    add_executable(${name} ${source})
    add_dependencies(fuzzers ${name})
    target_compile_options(${name} PRIVATE -fsanitize=fuzzer)
    target_link_options(${name} PRIVATE -fsanitize=fuzzer ${SANSO_TEST_LINKER})
    target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} PRIVATE ${A_LINK})
    set_property(GLOBAL APPEND PROPERTY SANSO_FUZZED ${A_LINK})
  endif()
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/tests/fuzz/corpus/${name})
    add_library(${name}_replay OBJECT ${source})
    target_compile_definitions(${name}_replay PRIVATE LLVMFuzzerTestOneInput=${name})
    target_include_directories(${name}_replay PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name}_replay PUBLIC ${A_LINK})
  endif()
endfunction()
