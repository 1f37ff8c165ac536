# SPDX-License-Identifier: Apache-2.0
# malha tune, bench and study: the benchmarks and `tune` are libraries, so that tests can use them, and one program runs
# both, and hands studies over to their scripts: see tools/measures.h.

# The benchmarks.
file(GLOB_RECURSE bench_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tools/bench/*.cpp")
if(NOT BULLET_FOUND)
  list(FILTER bench_sources EXCLUDE REGEX "/bullet[a-z_]*.cpp$")
endif()
if(NOT OPENBLAS_FOUND)
  list(REMOVE_ITEM bench_sources "${PROJECT_SOURCE_DIR}/tools/bench/peers/openblas.cpp")
endif()
add_library(malha_bench STATIC ${bench_sources})
set_target_properties(malha_bench PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
foreach(source IN LISTS bench_sources)
  get_filename_component(folder "${source}" DIRECTORY)
  get_filename_component(folder "${folder}" NAME)
  set_source_files_properties("${source}" PROPERTIES UNITY_GROUP "${folder}")
endforeach()
target_link_libraries(malha_bench PUBLIC malha PRIVATE nlohmann_json::nlohmann_json ${malha_openmp} Threads::Threads)
if(BULLET_FOUND)
  set_source_files_properties(tools/bench/projection/measure.cpp tools/bench/contact.cpp PROPERTIES COMPILE_DEFINITIONS
    MALHA_HAS_BULLET)
  target_include_directories(malha_bench SYSTEM PRIVATE ${BULLET_INCLUDE_DIRS})
  target_link_libraries(malha_bench PRIVATE ${BULLET_LIBRARIES})
endif()
if(OPENBLAS_FOUND)
  set_source_files_properties(tools/bench/filter/filter_case.cpp PROPERTIES COMPILE_DEFINITIONS MALHA_HAS_OPENBLAS)
  set_source_files_properties(tools/bench/peers/openblas.cpp PROPERTIES COMPILE_DEFINITIONS
    "OPENBLAS_FILE=\"${OPENBLAS_LIBRARY}\"")  # loaded by the benchmark only
  target_include_directories(malha_bench SYSTEM PRIVATE ${OPENBLAS_INCLUDE_DIR})
  target_link_libraries(malha_bench PRIVATE ${CMAKE_DL_LIBS})
endif()

file(GLOB tune_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tools/tune/*.cpp")
add_library(malha_tune STATIC ${tune_sources})
# Several files are compiled together, as in the tests: parsing the headers takes longer than the rest of a file.
set_target_properties(malha_tune PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
target_link_libraries(malha_tune PUBLIC malha malha_bench nlohmann_json::nlohmann_json PRIVATE ${malha_openmp})

# The studies are scripts in Python, which lie beside the program in a build and in a wheel.
file(GLOB study_scripts CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tools/study/*.py")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${study_scripts})
file(COPY ${study_scripts} DESTINATION "${PROJECT_BINARY_DIR}/study")

file(GLOB measures_sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/tools/measures/*.cpp")
add_executable(malha_measures ${measures_sources} tools/study/script.cpp)
target_link_libraries(malha_measures PRIVATE malha_command_line malha_bench malha_tune)
set_target_properties(malha_measures PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
