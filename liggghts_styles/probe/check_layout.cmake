if(NOT DEFINED BEDLOAD_LAYOUT_OF OR NOT BEDLOAD_LAYOUT_OF STREQUAL "${LIGGGHTS_LIBRARY}")
  message(STATUS "Checking that LIGGGHTS' headers fit its library")
  set(ENV{OMPI_ALLOW_RUN_AS_ROOT} 1)
  set(ENV{OMPI_ALLOW_RUN_AS_ROOT_CONFIRM} 1)
  unset(BEDLOAD_LAYOUT_RUN CACHE)
  unset(BEDLOAD_LAYOUT_COMPILED CACHE)
  try_run(BEDLOAD_LAYOUT_RUN BEDLOAD_LAYOUT_COMPILED
    ${CMAKE_CURRENT_BINARY_DIR}/layout ${CMAKE_CURRENT_SOURCE_DIR}/probe/layout.cpp
    LINK_LIBRARIES liggghts
    CXX_STANDARD 20
    COMPILE_OUTPUT_VARIABLE layout_compile
    RUN_OUTPUT_VARIABLE layout_said)
  if(NOT BEDLOAD_LAYOUT_COMPILED AND layout_compile MATCHES "undefined reference to .*Domain::remap")
    message(FATAL_ERROR "${LIGGGHTS_LIBRARY} counts in other integers than its headers do by default: build "
                        "LIGGGHTS with LAMMPS_SMALLBIG, its own default.")
  endif()
  if(NOT BEDLOAD_LAYOUT_COMPILED)
    message(FATAL_ERROR "A program with the headers in ${LIGGGHTS_INCLUDE_DIR} does not build against "
                        "${LIGGGHTS_LIBRARY}; the compiler said:\n${layout_compile}")
  endif()
  if(NOT BEDLOAD_LAYOUT_RUN EQUAL 0)
    message(FATAL_ERROR "The headers in ${LIGGGHTS_INCLUDE_DIR} do not fit ${LIGGGHTS_LIBRARY} "
                        "(${layout_said}): take both from one build of LIGGGHTS, made without "
                        "SUPERQUADRIC_ACTIVE_FLAG, NONSPHERICAL_ACTIVE_FLAG and CONVEX_ACTIVE_FLAG.")
  endif()
  set(BEDLOAD_LAYOUT_OF "${LIGGGHTS_LIBRARY}" CACHE INTERNAL "The library whose layout was checked")
endif()
