# What `cmake --install` puts where: libraries, headers, find_package and pkg-config files. The program's own rule is in
# apps/CMakeLists.txt.
include(CMakePackageConfigHelpers)

set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/holdfast)
set(installed_targets holdfast)
if(TARGET holdfast_io)
  list(APPEND installed_targets holdfast_io holdfast_detection)
endif()
set_target_properties(${installed_targets} PROPERTIES
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  INSTALL_RPATH "$ORIGIN")

install(TARGETS holdfast EXPORT holdfastTargets)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/holdfast DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.hpp" PATTERN "io.hpp" EXCLUDE PATTERN "detection.hpp" EXCLUDE)
install(EXPORT holdfastTargets NAMESPACE holdfast:: DESTINATION ${config_folder})
if(TARGET holdfast_io)
  install(TARGETS holdfast_io EXPORT holdfastIoTargets)
  install(TARGETS holdfast_detection EXPORT holdfastDetectionTargets)
  install(EXPORT holdfastDetectionTargets FILE holdfastDetectionTargets.cmake NAMESPACE holdfast:: DESTINATION
    ${config_folder})
  install(FILES ${PROJECT_SOURCE_DIR}/include/holdfast/io.hpp ${PROJECT_SOURCE_DIR}/include/holdfast/detection.hpp
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/holdfast)
  install(EXPORT holdfastIoTargets FILE holdfastIoTargets.cmake NAMESPACE holdfast:: DESTINATION ${config_folder})
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/holdfastConfig.cmake.in
  ${PROJECT_BINARY_DIR}/holdfastConfig.cmake INSTALL_DESTINATION ${config_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/holdfastConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/holdfastConfig.cmake ${PROJECT_BINARY_DIR}/holdfastConfigVersion.cmake
  DESTINATION ${config_folder})

# The prefix is found from the .pc file's own place, so that the installed tree can be moved.
file(RELATIVE_PATH HOLDFAST_PC_TO_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
if(BUILD_SHARED_LIBS)
  set(HOLDFAST_PC_REQUIRES eigen3)
  set(HOLDFAST_PC_LIBS)
  set(HOLDFAST_PC_IO_LIBS)
  set(HOLDFAST_PC_DETECTION_LIBS)
else()
  set(HOLDFAST_PC_REQUIRES "eigen3, OpenCL")
  set(HOLDFAST_PC_LIBS "-ldl")
  set(HOLDFAST_PC_IO_LIBS "-lopencv_imgcodecs -lopencv_imgproc -lopencv_core -lassimp -lfmt -lyaml-cpp")
  set(HOLDFAST_PC_DETECTION_LIBS "-lopencv_calib3d -lopencv_features2d -lopencv_flann -lopencv_imgproc -lopencv_core")
endif()
set(pc_names holdfast)
if(TARGET holdfast_io)
  list(APPEND pc_names holdfast-io holdfast-detection)
endif()
foreach(name ${pc_names})
  configure_file(${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
