# What SlicerExtensionCPack.cmake checks and writes before it makes a package.

foreach(file IN ITEMS EXTENSION_README_FILE EXTENSION_LICENSE_FILE)
  if(NOT EXISTS "${${file}}")
    message(FATAL_ERROR "${file} points to a file that does not exist: ${${file}}")
  endif()
endforeach()

if(CMAKE_VERSION VERSION_LESS 3.28)
  message(STATUS "Skipping the extension description: Slicer's function for it needs CMake 3.28, this is ${CMAKE_VERSION}")
  return()
endif()
include(SlicerFunctionGenerateExtensionDescription)
slicerFunctionGenerateExtensionDescription(
  EXTENSION_NAME ${EXTENSION_NAME}
  EXTENSION_HOMEPAGE ${EXTENSION_HOMEPAGE}
  EXTENSION_CONTRIBUTORS ${EXTENSION_CONTRIBUTORS}
  EXTENSION_DESCRIPTION ${EXTENSION_DESCRIPTION}
  EXTENSION_ICONURL ${EXTENSION_ICONURL}
  EXTENSION_SCREENSHOTURLS ${EXTENSION_SCREENSHOTURLS}
  EXTENSION_DEPENDS ${EXTENSION_DEPENDS}
  EXTENSION_RECOMMENDS ${EXTENSION_RECOMMENDS}
  EXTENSION_WC_TYPE local
  EXTENSION_WC_REVISION NA
  EXTENSION_WC_ROOT NA
  EXTENSION_WC_URL NA
  DESTINATION_DIR ${CMAKE_BINARY_DIR}
  SLICER_REVISION ${Slicer_REVISION}
  SLICER_WC_ROOT NA
  )
