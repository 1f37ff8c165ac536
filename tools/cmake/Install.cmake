# SPDX-License-Identifier: Apache-2.0
# Installation of the library, for find_package(malha CONFIG).
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
