# SPDX-License-Identifier: Apache-2.0
# Parts of malha that a build may leave out. MALHA_NAME is what the user asks for, MALHA_HAS_NAME what is built.
set(malha_components "")

# malha_component(NAME DEFAULT WHAT [NEEDS NAME...]): the option MALHA_NAME, which may be AUTO where that is the default.
# A part that is OFF takes those with it that need it and are AUTO; those that are ON are refused.
function(malha_component name default what)
  cmake_parse_arguments(PARSE_ARGV 3 of "" "" NEEDS)
  set(words ON OFF)
  if(default STREQUAL "AUTO")
    list(APPEND words AUTO)
    if(NOT PROJECT_IS_TOP_LEVEL AND of_NEEDS)  # a program
      set(default OFF)
    endif()
  endif()
  list(JOIN words ", " allowed)
  set(MALHA_${name} ${default} CACHE STRING "${what}: ${allowed}")
  set_property(CACHE MALHA_${name} PROPERTY STRINGS ${words})
  string(TOUPPER "${MALHA_${name}}" asked)
  string(REGEX REPLACE "^(TRUE|YES|1)$" ON asked "${asked}")
  string(REGEX REPLACE "^(FALSE|NO|0)$" OFF asked "${asked}")
  if(NOT asked IN_LIST words)
    message(FATAL_ERROR "MALHA_${name}: found \"${MALHA_${name}}\"; allowed: ${allowed}")
  endif()
  set(has ${asked})
  foreach(other IN LISTS of_NEEDS)
    if(NOT MALHA_HAS_${other})
      if(asked AND NOT asked STREQUAL "AUTO")
        message(FATAL_ERROR "MALHA_${name}: found ${MALHA_${name}} with MALHA_${other}=OFF; allowed: OFF, or "
                            "MALHA_${other}=ON")
      endif()
      set(has OFF)
    endif()
  endforeach()
  set(MALHA_HAS_${name} ${has} PARENT_SCOPE)
  set(malha_components ${malha_components} ${name} PARENT_SCOPE)
endfunction()

# malha_needs(NAME FOUND NEEDS): what a part needs, by its packages on Debian, is installed if FOUND is true. A part
# that is AUTO is left out without it, and one that is ON refused.
function(malha_needs name found needs)
  if(NOT MALHA_HAS_${name})
    return()
  endif()
  if(found)
    set(MALHA_HAS_${name} ON PARENT_SCOPE)
  elseif(MALHA_HAS_${name} STREQUAL "AUTO")
    set(MALHA_HAS_${name} OFF PARENT_SCOPE)
    message(STATUS "MALHA_${name} is left out: it needs ${needs}")
  else()
    message(FATAL_ERROR "MALHA_${name}: found ${MALHA_${name}}, but it needs ${needs}; allowed: OFF without it")
  endif()
endfunction()

# malha_instead(NAME FILES OTHERS): host_sources keep FILES of host/ where the part is built, and OTHERS elsewhere
# (without .cpp, separated by |).
function(malha_instead name files others)
  set(leave ${files})
  if(MALHA_HAS_${name})
    set(leave ${others})
  endif()
  if(leave)
    list(FILTER host_sources EXCLUDE REGEX "/host/(${leave})\\.cpp$")
    set(host_sources "${host_sources}" PARENT_SCOPE)
  endif()
endfunction()
