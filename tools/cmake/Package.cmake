# SPDX-License-Identifier: Apache-2.0
# Contents of the Debian package besides the program and the library: see tools/package/.
set(data_dir "${CMAKE_INSTALL_DATAROOTDIR}/malha")
install(DIRECTORY scenes/ DESTINATION "${data_dir}/scenes" PATTERN "scans" EXCLUDE PATTERN "*.md" EXCLUDE
        PATTERN "*.png" EXCLUDE)
install(FILES scenes/meshes/scans/bunny00.off DESTINATION "${data_dir}/scenes/meshes/scans" OPTIONAL)

# Pages, their pictures and the examples keep their folders, so that links between them work.
file(GLOB_RECURSE pages CONFIGURE_DEPENDS RELATIVE "${PROJECT_SOURCE_DIR}" host/*.md kernels/*.md scenes/*.md
     scenes/*.png tests/*.md tools/*.md tools/*.svg tools/examples/*.cpp tools/examples/CMakeLists.txt
     tools/python/examples/*.py tools/python/examples/*.ipynb tools/examples/*.py)
foreach(page README.md CONTRIBUTING.md CHANGELOG.md CITATION.cff ${pages})
  get_filename_component(folder "${page}" DIRECTORY)
  install(FILES "${page}" DESTINATION "${CMAKE_INSTALL_DOCDIR}/${folder}")
endforeach()
# The usual place of examples on Debian.
file(CREATE_LINK tools/examples "${PROJECT_BINARY_DIR}/examples" SYMBOLIC)
install(FILES "${PROJECT_BINARY_DIR}/examples" DESTINATION "${CMAKE_INSTALL_DOCDIR}")

# Files that tools/package/make writes.
install(FILES "${PROJECT_BINARY_DIR}/copyright" DESTINATION "${CMAKE_INSTALL_DOCDIR}" OPTIONAL)
install(DIRECTORY "${PROJECT_BINARY_DIR}/man/" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" OPTIONAL)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME malha)
set(CPACK_PACKAGE_CONTACT "the founders of malha")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Cloth, balloons and soft solids by Position Based Dynamics (XPBD) and
by Desbrun's implicit filter. The command and its window, the library with its
headers, the module for Python, scenes, pages and examples.")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # dependencies of the programs
# Tools and libraries for programs that use malha's library, and gnuplot for the charts of benchmarks, which run
# without it.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "g++, cmake, make, libembree-dev, libmetis-dev, libtinygltf-dev, zlib1g-dev, gnuplot-nox")
# The Python module needs numpy, and the command `malha study` does not run without all three: Debian's policy, 7.2, has
# Recommends for what an installation without it would be unusual.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-numpy, python3-scipy, python3-matplotlib")
include(CPack)
