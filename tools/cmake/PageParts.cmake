# SPDX-License-Identifier: Apache-2.0
# Common parts of all pages of host/output/page.h, as one source file.
set(page_folder "${PROJECT_SOURCE_DIR}/host/output/page")
set(page_files style "${page_folder}/style.css" body "${page_folder}/body.html" three "${THREE_JS}"
               controls "${THREE_CONTROLS_JS}" data "${page_folder}/data.js" looks "${page_folder}/looks.js"
               stage "${page_folder}/stage.js" panel "${page_folder}/panel.js" viewer "${page_folder}/viewer.js")
while(page_files)
  list(POP_FRONT page_files part path)
  file(READ "${path}" page_${part})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${path}")
endwhile()
set(page_parts "${PROJECT_BINARY_DIR}/page_parts.cpp")
configure_file("${page_folder}/parts.cpp.in" "${page_parts}" @ONLY)
