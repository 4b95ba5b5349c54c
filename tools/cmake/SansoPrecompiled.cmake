# Precompiled headers of the standard library, Eigen and GoogleTest, with -DSANSO_PRECOMPILED=ON: a build from nothing takes
# about half of the time. Off by default, because without them each file is seen to include what it uses, and compiler
# caches work across work trees. Included last: targets with compiler flags of their own are left as they are.
if(NOT SANSO_PRECOMPILED OR SANSO_FIRMWARE_ONLY)
  return()
endif()

set(standard <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <cstdio> <cstring> <filesystem> <fstream> <functional>
    <limits> <map> <memory> <mutex> <numeric> <optional> <random> <set> <span> <sstream> <stdexcept> <string> <string_view>
    <thread> <vector> <Eigen/Core> <Eigen/Cholesky> <Eigen/Geometry> <Eigen/LU> <Eigen/QR>)
file(WRITE ${PROJECT_BINARY_DIR}/empty.cpp "")
file(WRITE ${PROJECT_BINARY_DIR}/empty_main.cpp "int main() {}\n")
# Two, because libraries and programs are compiled with different kinds of position-independent code.
add_library(sanso_precompiled_library STATIC ${PROJECT_BINARY_DIR}/empty.cpp)
target_link_libraries(sanso_precompiled_library PRIVATE Eigen3::Eigen)
target_precompile_headers(sanso_precompiled_library PRIVATE ${standard})
if(SANSO_BUILD_TESTS)
  find_package(GTest REQUIRED)
  add_executable(sanso_precompiled_test ${PROJECT_BINARY_DIR}/empty_main.cpp)
  target_link_libraries(sanso_precompiled_test PRIVATE Eigen3::Eigen GTest::gtest GTest::gmock)
  target_precompile_headers(sanso_precompiled_test PRIVATE ${standard} <gtest/gtest.h> <gmock/gmock.h>)
endif()

# Uses the headers of `from` in a target, but for sources that have flags or definitions of their own.
function(sanso_use_precompiled target from)
  get_target_property(flags ${target} COMPILE_OPTIONS)
  get_directory_property(common COMPILE_OPTIONS)
  foreach(flag ${flags})
    if(NOT flag IN_LIST common)
      return()
    endif()
  endforeach()
  get_target_property(sources ${target} SOURCES)
  get_target_property(folder ${target} SOURCE_DIR)
  foreach(source ${sources})
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder})
    get_source_file_property(own_flags ${source} TARGET_DIRECTORY ${target} COMPILE_OPTIONS)
    if(own_flags)
      set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
    endif()
  endforeach()
  target_precompile_headers(${target} REUSE_FROM ${from})
endfunction()

get_property(libraries GLOBAL PROPERTY SANSO_LIBRARIES)
foreach(target ${libraries})
  sanso_use_precompiled(${target} sanso_precompiled_library)
endforeach()
get_property(tests GLOBAL PROPERTY SANSO_TESTS)
foreach(target ${tests})
  sanso_use_precompiled(${target} sanso_precompiled_test)
endforeach()
