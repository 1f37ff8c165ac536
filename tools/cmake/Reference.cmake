# SPDX-License-Identifier: Apache-2.0
# Reference pages of the public headers, in BUILD/reference/html: `cmake --build BUILD --target reference`.
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
  set(DOXYGEN_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/reference")
  set(DOXYGEN_PROJECT_BRIEF "${PROJECT_DESCRIPTION}")
  set(DOXYGEN_USE_MDFILE_AS_MAINPAGE "${PROJECT_SOURCE_DIR}/host/README.md")
  set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
  set(DOXYGEN_EXTRACT_ALL YES)
  set(DOXYGEN_QUIET YES)
  set(DOXYGEN_SOURCE_BROWSER YES)  # the example programs too
  file(GLOB_RECURSE pages RELATIVE "${PROJECT_SOURCE_DIR}" CONFIGURE_DEPENDS kernels/*.md host/*.md scenes/*.md tests/*.md
    *.md tools/examples/*.cpp)
  doxygen_add_docs(reference ${pages} ${public_headers} COMMENT "reference pages")
endif()

# Those of the Python module, by Sphinx, in BUILD/reference/python: `cmake --build BUILD --target python_reference`.
if(TARGET malha_python)
  add_custom_target(python_reference COMMENT "reference pages of the Python module" VERBATIM
    COMMAND ${CMAKE_COMMAND} -E env PYTHONDONTWRITEBYTECODE=1 "PYTHONPATH=${PROJECT_BINARY_DIR}"
            "${Python3_EXECUTABLE}" -m sphinx -q -W --keep-going
            -b html "${PROJECT_SOURCE_DIR}/tools/python/reference" "${PROJECT_BINARY_DIR}/reference/python")
  add_dependencies(python_reference malha_python)
endif()
