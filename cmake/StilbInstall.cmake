# Installs the stilb program with what it loads, the libraries of the engine, and the CMake package stilb, whose components
# are jobs, profiler, scene, engine and gi. The first two install themselves, as packages stilb-jobs and stilb-profiler:
# jobs/CMakeLists.txt and profiler/CMakeLists.txt.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stilb)
get_property(shaders_number GLOBAL PROPERTY STILB_SHADERS_NUMBER)
configure_package_config_file(cmake/stilb-config.cmake.in stilb-config.cmake INSTALL_DESTINATION ${package_dir})
# While the version is 0.x, every minor version may change an interface.
write_basic_package_version_file(stilb-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stilb-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/stilb-config-version.cmake
	DESTINATION ${package_dir})

if(NOT STILB_ENGINE)
	return()
endif()

# ---- what libraries start or load by themselves: base_part.c finds it here ----
install(TARGETS stilb RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS stilb-image-oiio LIBRARY DESTINATION lib/stilb)
if(TARGET stilb-farm-mpi)
	install(TARGETS stilb-farm-mpi LIBRARY DESTINATION lib/stilb)
endif()
install(TARGETS stilb-scene-import RUNTIME DESTINATION lib/stilb)
if(NOT PROJECT_IS_TOP_LEVEL) # the same places relative to the headers below
	set_target_properties(stilb-scene-import PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib/stilb)
	set_target_properties(stilb-image-oiio PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib/stilb)
endif()

# ---- headers ----
# The public headers, all that is installed. Each includes only headers of this list. Within Stilb a header is named by its
# module ("scene/scene.h"); users have all of them in one folder: <stilb/scene.h>.
set(headers
	base/base.h base/base_math.h
	image/image.h
	scene/scene.h scene/scene_animation.h scene/play/scene_play.h scene/scene_build.h scene/scene_channel.h scene/function/scene_function.h scene/scene_impostor.h scene/scene_look.h scene/open/scene_lights.h scene/scene_pick.h scene/scene_streams.h scene/scene_surface.h
	scene/edit/scene_edit.h scene/edit/scene_node.h scene/edit/scene_variant.h
	geometry/geometry.h geometry/geometry_levels.h geometry/geometry_detail.h geometry/geometry_impostor.h geometry/geometry_lights.h geometry/horde/geometry_horde.h
	shading/shade_model.h
	window/window.h
	input/input.h input/input_actions.h input/input_camera.h input/input_control.h input/input_pad.h
	culling/cull.h
	light/light.h shadow/shadow.h
	gpu/gpu.h gpu/gpu_device.h gpu/gpu_format.h gpu/gpu_plan.h
	render/render.h
	ui/ui_draw.h
	debug/debug_draw.h
	post/post.h
	post/post_table.h
	post/post_preset.h
	engine.h
	gi/gi_scene.h gi/gi_render.h)
set(elsewhere jobs/job.h profiler/prof_capture.h) # public headers of the libraries that install themselves
set(made ${PROJECT_BINARY_DIR}/include/stilb)
set(installed)
foreach(header ${headers})
	file(READ engine/${header} text)
	string(REGEX MATCHALL "#include \"[^\"]*\"" includes "${text}")
	foreach(include ${includes})
		string(REGEX REPLACE ".*\"(.*)\"" "\\1" include "${include}")
		if(NOT include IN_LIST headers AND NOT include IN_LIST elsewhere)
			message(FATAL_ERROR "${header} is public and includes ${include}, which is not: add it to StilbInstall.cmake")
		endif()
	endforeach()
	string(REGEX REPLACE "#include \"[^\"]*/([^\"/]*)\"" "#include <stilb/\\1>" text "${text}")
	string(REPLACE "#if 0 /* 1 in the copy of this header that is installed */\n" "#if 1\n" text "${text}")
	get_filename_component(name ${header} NAME)
	file(CONFIGURE OUTPUT ${made}/${name} CONTENT "${text}" @ONLY)
	list(APPEND installed ${made}/${name})
	set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS engine/${header})
endforeach()
install(FILES ${installed} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stilb)

# ---- shaders, from which stilb_surface() makes surface functions ----
file(GLOB shaders CONFIGURE_DEPENDS engine/render/shaders/*.glsl engine/render/shaders/*.inc)
file(GLOB formulas CONFIGURE_DEPENDS engine/shading/*.h)
install(FILES engine/render/shaders/maps.frag ${shaders} DESTINATION ${CMAKE_INSTALL_DATADIR}/stilb/shaders/render/shaders)
install(FILES engine/render/shaders/deferred/lists.glsl DESTINATION ${CMAKE_INSTALL_DATADIR}/stilb/shaders/render/shaders/deferred)
install(FILES engine/render/shaders/hdr/hdr.glsl DESTINATION ${CMAKE_INSTALL_DATADIR}/stilb/shaders/render/shaders/hdr)
install(FILES engine/render/shaders/shadow/shadow.glsl DESTINATION ${CMAKE_INSTALL_DATADIR}/stilb/shaders/render/shaders/shadow)
install(FILES engine/render/shaders/velocity/beside.glsl DESTINATION ${CMAKE_INSTALL_DATADIR}/stilb/shaders/render/shaders/velocity)
install(FILES ${formulas} DESTINATION ${CMAKE_INSTALL_DATADIR}/stilb/shaders/shading)
install(FILES cmake/StilbSurface.cmake DESTINATION ${package_dir})

target_include_directories(stilb-base INTERFACE
	$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)

file(STRINGS engine/base/base.h version REGEX "^#define STILB_VERSION_(MAJOR|MINOR|PATCH) ")
list(TRANSFORM version REPLACE ".* " "")
list(JOIN version . version)
if(NOT version VERSION_EQUAL PROJECT_VERSION)
	message(FATAL_ERROR "base.h says version ${version}, CMakeLists.txt ${PROJECT_VERSION}")
endif()

# ---- libraries ----
# stilb_component(NAME DESCRIPTION MODULES m... REQUIRES package... LIBS -lx...): a component of the package, in CMake and as
# stilb-NAME in pkg-config: static libraries, in the order for the linker, and what else must be linked.
function(stilb_component name description)
	cmake_parse_arguments(arg "" "" "MODULES;REQUIRES;LIBS" ${ARGN})
	list(TRANSFORM arg_MODULES PREPEND stilb- OUTPUT_VARIABLE targets)
	install(TARGETS ${targets} EXPORT stilb-${name}-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
	install(EXPORT stilb-${name}-targets NAMESPACE stilb:: DESTINATION ${package_dir})
	list(REMOVE_ITEM arg_MODULES shading) # headers alone
	list(TRANSFORM arg_MODULES PREPEND -lstilb- OUTPUT_VARIABLE libs)
	list(JOIN arg_REQUIRES " " requires)
	list(JOIN libs " " libs)
	list(JOIN arg_LIBS " " more)
	# The prefix is found from where the .pc file lies, so that an installed tree can be moved.
	file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
	configure_file(cmake/stilb-component.pc.in stilb-${name}.pc @ONLY)
	install(FILES ${CMAKE_CURRENT_BINARY_DIR}/stilb-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

stilb_component(scene "Scenes as plain data: files, a builder, pictures"
	MODULES scene numeric image base shading # numeric: of render and gi, which both need scene
	REQUIRES stilb-jobs stilb-profiler libpng OpenEXR LIBS -lstdc++ -lm -ldl -pthread)
stilb_component(geometry "Coarser levels and impostors of meshes"
	MODULES geometry
	REQUIRES stilb-scene stilb-jobs stilb-profiler)
stilb_component(engine "${PROJECT_DESCRIPTION}"
	MODULES engine debug post ui render shadow light gpu culling input window
	REQUIRES stilb-scene stilb-jobs stilb-profiler glfw3 vulkan hidapi-hidraw)
stilb_component(gi "Pictures of scenes by ray tracing"
	MODULES gi farm
	REQUIRES stilb-scene stilb-jobs stilb-profiler LIBS -lembree3 -ltbb -lstdc++)

# ---- the shared library ----
# One library for all modules. It exports what the public headers mark, and only that. With BUILD_SHARED_LIBS it is installed as
# well, and then the components are it; so they are after `cmake --install BUILD --component shared`.
#
# Its profiler is compiled for it, without hidden functions and with shared/prof_image.c: the zones of a program that is compiled
# with STILB_PROF_SHARED are recorded there. Linked statically, each program or shared object has a profiler of its own.
get_target_property(sources stilb-profiler SOURCES)
list(TRANSFORM sources PREPEND profiler/)
add_library(stilb-profiler-shared OBJECT EXCLUDE_FROM_ALL ${sources} profiler/shared/prof_image.c)
set_target_properties(stilb-profiler-shared PROPERTIES C_VISIBILITY_PRESET default)
target_compile_definitions(stilb-profiler-shared PRIVATE PROF_IMAGES)
target_include_directories(stilb-profiler-shared PRIVATE $<TARGET_PROPERTY:stilb-profiler,INCLUDE_DIRECTORIES>)
target_link_libraries(stilb-profiler-shared PRIVATE stilb-flags)
set(shared_definitions STILB_PROF_SHARED)
if(NOT STILB_PROFILE)
	list(APPEND shared_definitions STILB_PROFILE_OFF)
endif()
set(modules engine debug post ui render shadow light gpu culling input window gi farm numeric geometry scene image base jobs profiler-shared)
list(TRANSFORM modules REPLACE "(.+)" "$<TARGET_OBJECTS:stilb-\\1>" OUTPUT_VARIABLE objects)
add_library(stilb-shared SHARED ${objects})
target_link_libraries(stilb-shared PRIVATE stilb-engine stilb-gi stilb-geometry stilb-flags # for the libraries of others that these need
	INTERFACE m) # functions in headers call it
target_link_options(stilb-shared PRIVATE -Wl,-z,defs -Wl,--version-script=${PROJECT_SOURCE_DIR}/cmake/stilb-exports.map)
set_target_properties(stilb-shared PROPERTIES OUTPUT_NAME stilb EXPORT_NAME shared LINKER_LANGUAGE CXX
	VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} # 0.x: each minor may break
	LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/stilb-exports.map)
target_compile_definitions(stilb-shared INTERFACE ${shared_definitions})
target_include_directories(stilb-shared INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
set(shared COMPONENT shared)
if(NOT BUILD_SHARED_LIBS)
	list(APPEND shared EXCLUDE_FROM_ALL)
	if(NOT STILB_TESTS OR STILB_SANITIZE)
		set_target_properties(stilb-shared PROPERTIES EXCLUDE_FROM_ALL ON)
	endif()
endif()
install(TARGETS stilb-shared EXPORT stilb-shared-targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} ${shared}
	NAMELINK_COMPONENT shared)
install(EXPORT stilb-shared-targets NAMESPACE stilb:: DESTINATION ${package_dir} ${shared})
list(TRANSFORM shared_definitions PREPEND -D OUTPUT_VARIABLE cflags)
list(JOIN cflags " " cflags)
foreach(name jobs profiler scene geometry engine gi)
	set(description "Stilb's ${name}, in the shared library of all of Stilb")
	set(requires)
	set(libs -lstilb)
	set(more -lm)
	file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
	configure_file(cmake/stilb-component.pc.in shared/stilb-${name}.pc @ONLY)
	# The static library's file, if it is there, may be as old to the second, and would be taken for this one.
	install(CODE "file(REMOVE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/pkgconfig/stilb-${name}.pc\")" ${shared})
	install(FILES ${CMAKE_CURRENT_BINARY_DIR}/shared/stilb-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig ${shared})
endforeach()
