# SPDX-License-Identifier: Apache-2.0
# Installation of the library, for find_package(malha CONFIG), of the programs that are built, and of the licences.
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/malha")
install(TARGETS malha EXPORT malhaTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT malhaTargets NAMESPACE malha:: DESTINATION ${package_dir})

# The public headers include neither Eigen nor kernels, so that callers may use other compiler flags.
file(GLOB public_headers CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}" host/malha/*.h)
install(FILES ${public_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/malha)

configure_package_config_file(tools/cmake/malhaConfig.cmake.in malhaConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(malhaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/malhaConfig.cmake" "${PROJECT_BINARY_DIR}/malhaConfigVersion.cmake"
        DESTINATION ${package_dir})
install(FILES LICENSE "${PROJECT_BINARY_DIR}/THIRD_PARTY" DESTINATION ${CMAKE_INSTALL_DOCDIR})

if(MALHA_HAS_COMMAND)
  install(TARGETS malha_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(FILES tools/package/completion/malha.bash RENAME malha
          DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions")
  install(FILES tools/package/completion/_malha DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/zsh/site-functions")
  install(FILES tools/package/completion/malha.fish
          DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/fish/vendor_completions.d")
endif()
if(MALHA_HAS_MEASURES)
  install(TARGETS malha_measures RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} OPTIONAL)  # if it was built
  install(FILES ${study_scripts} DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/malha/study")
endif()
if(MALHA_HAS_WINDOW)
  install(TARGETS malha_view RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} OPTIONAL)
  install(FILES tools/package/malha.desktop DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/applications")
  install(FILES tools/package/malha.svg DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/icons/hicolor/scalable/apps")
endif()
if(MALHA_HAS_PYTHON)
  install(TARGETS malha_python LIBRARY DESTINATION "${MALHA_PYTHON_DIR}")
  install(FILES tools/python/malha.py DESTINATION "${MALHA_PYTHON_DIR}")
  install(DIRECTORY tools/python/malha-stubs DESTINATION "${MALHA_PYTHON_DIR}")
  if(TARGET malha_python_reference)
    install(TARGETS malha_python_reference LIBRARY DESTINATION "${MALHA_PYTHON_DIR}" OPTIONAL)
  endif()
endif()
