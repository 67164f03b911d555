# The part of UseSlicer.cmake that a scripted extension uses.

option(BUILD_TESTING "Register the tests." ON)
if(BUILD_TESTING)
  enable_testing()
endif()

# Byte-compiling looks for Python with modules that CMake 3.27 removed; any interpreter does here.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(PYTHON_EXECUTABLE "${Python3_EXECUTABLE}")
set(PYTHONINTERP_FOUND TRUE)
set(PYTHONLIBS_FOUND TRUE)
function(ctkFunctionExtractOptimizedLibrary)
endfunction()

include(ExternalData)
set(ExternalData_OBJECT_STORES "${CMAKE_BINARY_DIR}")
include(ctkMacroCompilePythonScript)
include(SlicerMacroPythonTesting)
include(SlicerMacroConfigureGenericPythonModuleTests)
include(SlicerMacroBuildScriptedModule)
