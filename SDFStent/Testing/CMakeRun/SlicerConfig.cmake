# Configures, builds and installs this extension with Slicer's and CTK's own macros, without a Slicer build:
#
#   cmake -S . -B build -DSlicer_DIR=SDFStent/Testing/CMakeRun -DBUILD_TESTING=ON \
#         -DSlicer_CHECKOUT=<Slicer sources> -DCTK_CHECKOUT=<CTK sources>
#   cmake --build build && cmake --install build --prefix <folder>
#
# It sets what a Slicer build tree would, and nothing of Slicer or CTK is copied here.

foreach(checkout IN ITEMS Slicer_CHECKOUT CTK_CHECKOUT)
  if(NOT IS_DIRECTORY "${${checkout}}/CMake")
    message(FATAL_ERROR "${checkout} must name a folder of sources, got '${${checkout}}'")
  endif()
endforeach()

set(CTK_CMAKE_DIR "${CTK_CHECKOUT}/CMake")
set(Slicer_CMAKE_DIR "${Slicer_CHECKOUT}/CMake")
list(APPEND CMAKE_MODULE_PATH "${Slicer_CMAKE_DIR}" "${Slicer_CHECKOUT}/Extensions/CMake" "${CTK_CMAKE_DIR}")

set(Slicer_FOUND TRUE)
set(Slicer_USE_PYTHONQT TRUE)
set(Slicer_VERSION_MAJOR 5)
set(Slicer_VERSION_MINOR 13)
set(Slicer_REVISION 0)
set(Slicer_OS linux)
set(Slicer_ARCHITECTURE amd64)
set(Slicer_ORGANIZATION_NAME "None")
set(Slicer_LIB_DIR "lib/Slicer-5.13")
set(Slicer_SHARE_DIR "share/Slicer-5.13")
set(Slicer_QTSCRIPTEDMODULES_LIB_DIR "${Slicer_LIB_DIR}/qt-scripted-modules")
set(Slicer_CLIMODULES_LIB_DIR "${Slicer_LIB_DIR}/cli-modules")
set(Slicer_QTLOADABLEMODULES_LIB_DIR "${Slicer_LIB_DIR}/qt-loadable-modules")
set(Slicer_INSTALL_ROOT "./")
set(Slicer_INSTALL_QTSCRIPTEDMODULES_LIB_DIR "${Slicer_INSTALL_ROOT}${Slicer_QTSCRIPTEDMODULES_LIB_DIR}")
set(Slicer_PYTHON_MODULE_TEST_TEMPLATES_DIR "${Slicer_CHECKOUT}/Base/QTCore/Testing/Python")
set(Slicer_LAUNCHER_EXECUTABLE "Slicer")
set(Slicer_ExternalData_DATA_MANAGEMENT_TARGET "ExternalData")
set(EXTENSION_NAME "${PROJECT_NAME}")

set(Slicer_USE_FILE "${CMAKE_CURRENT_LIST_DIR}/UseSlicer.cmake")
set(Slicer_EXTENSION_GENERATE_CONFIG "${Slicer_CMAKE_DIR}/SlicerExtensionGenerateConfig.cmake")
set(Slicer_EXTENSION_CPACK "${CMAKE_CURRENT_LIST_DIR}/Description.cmake")
