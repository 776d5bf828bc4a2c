# Holdfast as strangers meet it: its public headers alone, its batch script, and installed, with find_package and with
# pkg-config.
find_package(Eigen3 REQUIRED NO_MODULE)
find_program(SHELL_PROGRAM sh REQUIRED)
get_target_property(eigen_folders Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
list(GET eigen_folders 0 eigen_folder)
add_test(NAME public_headers COMMAND ${SHELL_PROGRAM} ${CMAKE_CURRENT_SOURCE_DIR}/public_headers.sh
  ${PROJECT_SOURCE_DIR}/include ${CMAKE_CXX_COMPILER} ${eigen_folder})

add_test(NAME batch COMMAND ${SHELL_PROGRAM} ${CMAKE_CURRENT_SOURCE_DIR}/batch.sh
  ${PROJECT_SOURCE_DIR} $<TARGET_FILE:holdfast_program> ${CMAKE_CURRENT_BINARY_DIR}/batch)

add_test(NAME install_deps COMMAND ${SHELL_PROGRAM} ${CMAKE_CURRENT_SOURCE_DIR}/install_deps.sh
  ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_BINARY_DIR}/install_deps)

set(installed ${CMAKE_CURRENT_BINARY_DIR}/installed)
set(consumer ${CMAKE_CURRENT_SOURCE_DIR}/consumer)
add_test(NAME install COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --prefix ${installed})
set_tests_properties(install PROPERTIES FIXTURES_SETUP installed)
add_test(NAME installed_program COMMAND ${SHELL_PROGRAM} ${CMAKE_CURRENT_SOURCE_DIR}/installed_program.sh
  ${installed} ${CMAKE_INSTALL_BINDIR}/holdfast ${CMAKE_CURRENT_BINARY_DIR}/installed_program)
add_test(NAME consumer_cmake COMMAND ${SHELL_PROGRAM} ${consumer}/with_cmake.sh
  ${installed} ${CMAKE_CURRENT_BINARY_DIR}/consumer_cmake ${CMAKE_CXX_COMPILER})
add_test(NAME consumer_pkg_config COMMAND ${SHELL_PROGRAM} ${consumer}/with_pkg_config.sh
  ${installed} ${CMAKE_CURRENT_BINARY_DIR}/consumer_pkg_config ${CMAKE_CXX_COMPILER})
add_test(NAME consumer_documents COMMAND ${SHELL_PROGRAM} ${consumer}/documents.sh
  ${installed} ${CMAKE_CURRENT_BINARY_DIR}/consumer_documents ${CMAKE_CXX_COMPILER} ${CMAKE_C_COMPILER})
set_tests_properties(installed_program consumer_cmake consumer_pkg_config consumer_documents PROPERTIES FIXTURES_REQUIRED installed)
foreach(library holdfast holdfast_io holdfast_detection)
  file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/objects/${library}
    CONTENT "$<JOIN:$<TARGET_OBJECTS:${library}>,\n>\n")
endforeach()
add_test(NAME consumer_shared COMMAND ${SHELL_PROGRAM} ${consumer}/shared.sh
  ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR} ${CMAKE_CURRENT_BINARY_DIR}/shared ${CMAKE_CXX_COMPILER})
