# A room is one folder with one static library and an explicit list of the rooms and packages it may use.
# What is not listed is not on the include path, so the dependency rule of ARCHITECTURE.md is enforced by the
# compiler; tests/architecture checks the same rule on the text of the sources.

add_library(nmc_warnings INTERFACE)
target_compile_options(nmc_warnings INTERFACE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion
                                              $<$<BOOL:${NMC_WARNINGS_AS_ERRORS}>:-Werror>)

# Reconstruction must give the same bits everywhere: no contraction to fused multiply-add, no fast-math.
add_library(nmc_exact_floating_point INTERFACE)
target_compile_options(nmc_exact_floating_point INTERFACE -ffp-contract=off -fno-fast-math)

# g++ 12 drops the rounding of double(float(x)) where it vectorizes neighbouring members (-O2 and above): the
# codec's own rooms are compiled without that pass. tests/determinism has the program that shows it.
add_library(nmc_exact_rounding INTERFACE)
target_compile_options(nmc_exact_rounding INTERFACE $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)

# nmc_add_room(NAME [SOURCES files...] [USES rooms...] [PACKAGES targets...])
# NAME becomes the library nmc_NAME with an alias nmc::NAME. Without SOURCES every *.cpp of the folder is taken,
# except those that end in _main.cpp.
function(nmc_add_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;USES;PACKAGES" ${ARGN})
  if(NOT ROOM_SOURCES)
    file(GLOB ROOM_SOURCES CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
    list(FILTER ROOM_SOURCES EXCLUDE REGEX "_main\\.cpp$")
  endif()
  if(ROOM_SOURCES)
    add_library(nmc_${name} STATIC ${ROOM_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(nmc_${name} PRIVATE nmc_warnings)
  else()
    add_library(nmc_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(nmc::${name} ALIAS nmc_${name})
  target_link_libraries(nmc_${name} ${scope} nmc_exact_floating_point ${ROOM_PACKAGES})
  foreach(used IN LISTS ROOM_USES)
    target_link_libraries(nmc_${name} ${scope} nmc_${used})
  endforeach()
  target_include_directories(nmc_${name} ${scope} "${PROJECT_SOURCE_DIR}")
endfunction()
