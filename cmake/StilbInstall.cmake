# What `cmake --install` puts where: the profiler with its header, CMake package and pkg-config file, and the stilb
# program. jobs/CMakeLists.txt does the same for its library; the package stilb gives both.
# Users write #include <stilb/prof.h>, whether installed or with add_subdirectory.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

configure_file(profiler/prof.h include/stilb/prof.h COPYONLY)
target_include_directories(stilb-profiler INTERFACE
	$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
set_target_properties(stilb-profiler PROPERTIES EXPORT_NAME profiler)
install(TARGETS stilb-profiler EXPORT stilb-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(FILES profiler/prof.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stilb)

# The prefix is found from where the .pc file lies, so that an installed tree can be moved.
file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/stilb-profiler.pc.in stilb-profiler.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stilb-profiler.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stilb)
configure_package_config_file(cmake/stilb-config.cmake.in stilb-config.cmake INSTALL_DESTINATION ${package_dir})
# 0.x: every minor version may change an interface.
write_basic_package_version_file(stilb-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stilb-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/stilb-config-version.cmake
	DESTINATION ${package_dir})
install(EXPORT stilb-targets NAMESPACE stilb:: DESTINATION ${package_dir})

if(TARGET stilb)
	install(TARGETS stilb RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
	install(TARGETS stilb-image-oiio LIBRARY DESTINATION lib/stilb) # ../lib/stilb from the program: image_codec.c
endif()
