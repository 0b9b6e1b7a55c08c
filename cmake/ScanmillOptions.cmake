# Language, warnings and the floating-point rules that make results a pure function of the input.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(SCANMILL_CCACHE ccache)
if(SCANMILL_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${SCANMILL_CCACHE})
endif()

# Rounding a double to float and back is part of the results (mesh positions are float32 values). GCC 12, Debian 12's, drops the
# pair at -O2 when its straight-line vectoriser meets neighbouring struct members, so that vectoriser is off; loops are not
# affected. tests/base/test_float32.cpp fails without the flag.
# One target carries the flags, so foreign headers (SYSTEM) stay out of -Werror.
add_library(scanmill_options INTERFACE)
target_compile_options(scanmill_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Werror
  -ffp-contract=off -fno-fast-math -fno-unsafe-math-optimizations -fno-tree-slp-vectorize)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees overlaps in `"text" + std::string` that are not there (GCC bug 105651).
  target_compile_options(scanmill_options INTERFACE -Wno-restrict)
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_options(scanmill_options INTERFACE -O3)
endif()
if(SCANMILL_SANITIZE)
  target_compile_options(scanmill_options INTERFACE -fsanitize=${SCANMILL_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(scanmill_options INTERFACE -fsanitize=${SCANMILL_SANITIZE})
endif()

# scanmill_module(NAME [LIBS foreign-and-own targets]): one library per folder, all .cpp in it.
function(scanmill_module name)
  cmake_parse_arguments(M "" "" "LIBS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_library(scanmill_${name} STATIC ${sources})
  target_include_directories(scanmill_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(scanmill_${name} PRIVATE scanmill_options)
  foreach(lib IN LISTS M_LIBS)
    target_link_libraries(scanmill_${name} PUBLIC ${lib})
  endforeach()
endfunction()

# scanmill_test(NAME [LABELS ...] [LIBS ...]): one GoogleTest program per folder of tests/.
function(scanmill_test name)
  cmake_parse_arguments(T "" "" "LIBS;LABELS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_executable(test_${name} ${sources})
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(test_${name} PRIVATE scanmill_options ${T_LIBS} GTest::gtest_main)
  gtest_discover_tests(test_${name} TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS "${T_LABELS}" ENVIRONMENT
    "SCANMILL_DATA=$ENV{SCANMILL_DATA};TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/race.supp")
endfunction()
