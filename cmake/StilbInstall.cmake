# What `cmake --install` puts where: the stand-alone libraries with their header, CMake package and pkg-config file,
# and the stilb program. Users write #include <stilb/job.h>, whether installed or with add_subdirectory.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# stilb_install_library(NAME header.h "description")
function(stilb_install_library name header description)
	get_filename_component(file ${header} NAME)
	configure_file(${header} ${PROJECT_BINARY_DIR}/include/stilb/${file} COPYONLY)
	target_include_directories(stilb-${name} INTERFACE
		$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
	set_target_properties(stilb-${name} PROPERTIES EXPORT_NAME ${name})
	install(TARGETS stilb-${name} EXPORT stilb-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
	install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stilb)

	# The prefix is found from where the .pc file lies, so that an installed tree can be moved.
	file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
	configure_file(${PROJECT_SOURCE_DIR}/cmake/stilb.pc.in stilb-${name}.pc @ONLY)
	install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stilb-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

stilb_install_library(jobs jobs/job.h "Worker pool, parallel-for and job groups on a low-lock queue")
stilb_install_library(profiler profiler/prof.h "Frame profiler: scopes, per-thread rings, trace export")

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
