# stilb_module(NAME SOURCES a.c b.c [DEPS stilb-x ...] [PRIVATE_DEPS lib ...])
# One folder = one module = one static library called stilb-NAME. Headers are included by a path that names their
# module: "jobs/job.h" and "profiler/prof.h" from the top, "culling/cull.h" from engine/.
function(stilb_module name)
	cmake_parse_arguments(arg "" "" "SOURCES;DEPS;PRIVATE_DEPS" ${ARGN})
	add_library(stilb-${name} STATIC ${arg_SOURCES})
	add_library(stilb::${name} ALIAS stilb-${name})
	set_target_properties(stilb-${name} PROPERTIES EXPORT_NAME ${name})
	target_include_directories(stilb-${name} PUBLIC
		$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/engine>)
	target_link_libraries(stilb-${name} PUBLIC ${arg_DEPS} PRIVATE $<BUILD_INTERFACE:stilb-flags> ${arg_PRIVATE_DEPS})
endfunction()

# How shaders are compiled, by the build and by --watch-shaders.
set(STILB_GLSLC_FLAGS --target-env=vulkan1.3 -O -Werror)

# stilb_shaders(TARGET "SOURCE [OUTPUT [DEFINITION ...]]"...): compiles shaders to C initialisers (words in braces), which the
# target's sources include as OUTPUT.inc; OUTPUT is the name of the source unless it is given. shader_sources.h defines
# SOURCE_OUTPUT, with _ for dots, for stilb_gpu_shader.source: the file, below engine/ or with its whole path, and its
# definitions. Shaders may include others, so glslc writes what they depend on. What the preset release has compiled is copied
# (shader.sh).
function(stilb_shaders target)
	find_program(STILB_GLSLC glslc REQUIRED)
	set(folder ${CMAKE_CURRENT_BINARY_DIR}/shaders)
	file(MAKE_DIRECTORY ${folder}/${target})
	set(names)
	cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${PROJECT_BINARY_DIR} OUTPUT_VARIABLE place)
	foreach(line ${ARGN})
		separate_arguments(words UNIX_COMMAND "${line}")
		list(POP_FRONT words source output)
		if(NOT output)
			get_filename_component(output ${source} NAME)
		endif()
		list(TRANSFORM words PREPEND -D)
		get_filename_component(path ${source} ABSOLUTE)
		string(REPLACE ${PROJECT_SOURCE_DIR}/engine/ "" path ${path})
		list(JOIN words " " definitions)
		string(STRIP "${path} ${definitions}" path)
		string(REPLACE . _ name ${output})
		string(APPEND names "#define SOURCE_${name} \"${path}\"\n")
		add_custom_command(
			OUTPUT ${folder}/${output}.inc
			COMMAND ${PROJECT_SOURCE_DIR}/cmake/shader.sh ${PROJECT_SOURCE_DIR}/build/release/${place}/${output}.inc
				${folder}/${output}.inc ${STILB_GLSLC} ${STILB_GLSLC_FLAGS} ${words} -mfmt=c -MD -MF ${folder}/${output}.d
				-MT ${folder}/${output}.inc -o ${folder}/${output}.inc ${CMAKE_CURRENT_SOURCE_DIR}/${source}
			DEPENDS ${source}
			DEPFILE ${folder}/${output}.d
			VERBATIM)
		target_sources(${target} PRIVATE ${folder}/${output}.inc)
	endforeach()
	file(CONFIGURE OUTPUT ${folder}/${target}/shader_sources.h CONTENT "/* Written by stilb_shaders. */\n${names}" @ONLY)
	target_include_directories(${target} PRIVATE ${folder} ${folder}/${target})
endfunction()
