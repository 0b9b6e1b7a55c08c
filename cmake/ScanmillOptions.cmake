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
if(SCANMILL_SANITIZE)
  target_compile_options(scanmill_options INTERFACE -fsanitize=${SCANMILL_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(scanmill_options INTERFACE -fsanitize=${SCANMILL_SANITIZE})
endif()

# scanmill_batch(MODULE NUMBER files): one file in the build folder that includes them; its name goes to `sources`.
macro(scanmill_batch module number)
  set(text "")
  foreach(source ${ARGN})
    string(APPEND text "#include \"${module}/${source}\"\n")
  endforeach()
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${module}_${number}.cpp CONTENT "${text}" @ONLY)
  list(APPEND sources ${CMAKE_CURRENT_BINARY_DIR}/${module}_${number}.cpp)
endmacro()

# scanmill_module(NAME [BATCHED] [LEVEL -On] [APART files] [LIBS foreign-and-own targets]): one library per folder, all .cpp in it.
# A release is -O3 (CMake's own flags). LEVEL: for modules whose time does not count. BATCHED: eight files of the module are
# compiled as one, so that what they include is read once; files named after APART, whose private names meet those of a
# neighbour, make a batch of their own. -DSCANMILL_BATCHES=OFF compiles every file alone: right while one file is being edited,
# and the debug and sanitize presets do, so that no file lives on what its neighbours include.
function(scanmill_module name)
  cmake_parse_arguments(M "BATCHED" "LEVEL" "LIBS;APART" ${ARGN})
  file(GLOB sources RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  set(quieter "")
  if(SCANMILL_BATCHES AND M_BATCHED)
    # CMake's own batches hold absolute paths, and a compiler cache would take another clone's for other files.
    set(together ${sources})
    list(REMOVE_ITEM together ${M_APART} "")
    set(sources "")
    set(number 0)
    while(together)
      list(SUBLIST together 0 8 batch)
      scanmill_batch(${name} ${number} ${batch})
      list(REMOVE_ITEM together ${batch})
      math(EXPR number "${number} + 1")
    endwhile()
    if(M_APART)
      scanmill_batch(${name} apart ${M_APART})
    endif()
    # A struct nested in a class may hold members of a file's private types; in a batch that file is not the main one.
    set(quieter -Wno-subobject-linkage)
  endif()
  add_library(scanmill_${name} STATIC ${sources})
  target_include_directories(scanmill_${name} PUBLIC ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(scanmill_${name} PRIVATE scanmill_options)
  foreach(lib IN LISTS M_LIBS)
    target_link_libraries(scanmill_${name} PUBLIC ${lib})
  endforeach()
  if(CMAKE_BUILD_TYPE STREQUAL "Release" AND M_LEVEL)
    target_compile_options(scanmill_${name} PRIVATE ${M_LEVEL})
  endif()
  target_compile_options(scanmill_${name} PRIVATE ${quieter})
endfunction()

# scanmill_test(NAME [LABELS ...] [TIMEOUT s] [LIBS ...]): one GoogleTest program per folder of tests/.
function(scanmill_test name)
  cmake_parse_arguments(T "" "TIMEOUT" "LIBS;LABELS" ${ARGN})
  if(NOT T_TIMEOUT)
    set(T_TIMEOUT 1500)
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_executable(test_${name} ${sources})
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(test_${name} PRIVATE scanmill_options ${T_LIBS} GTest::gtest_main)
  gtest_discover_tests(test_${name} TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 60
    PROPERTIES LABELS "${T_LABELS}" TIMEOUT ${T_TIMEOUT} ENVIRONMENT
    "SCANMILL_DATA=$ENV{SCANMILL_DATA};TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/race.supp")
endfunction()
