# Installs the stilb program with what it loads, and the CMake package stilb, which stands for the packages stilb-jobs and
# stilb-profiler together. Those two install themselves: jobs/CMakeLists.txt and profiler/CMakeLists.txt.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stilb)
configure_package_config_file(cmake/stilb-config.cmake.in stilb-config.cmake INSTALL_DESTINATION ${package_dir})
# While the version is 0.x, every minor version may change an interface.
write_basic_package_version_file(stilb-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stilb-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/stilb-config-version.cmake
	DESTINATION ${package_dir})

if(TARGET stilb)
	install(TARGETS stilb RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
	install(TARGETS stilb-image-oiio LIBRARY DESTINATION lib/stilb) # image_foreign.c looks for it in ../lib/stilb from the program
	install(TARGETS stilb-scene-import RUNTIME DESTINATION lib/stilb) # so does scene_import.c
endif()
