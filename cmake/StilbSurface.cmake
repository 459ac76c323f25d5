# stilb_surface(TARGET NAME FILE): compiles a surface function, GLSL as render/shaders/surface.glsl says, into each of the
# shaders that it becomes a part of, and writes NAME.surface.h, which TARGET can include: it defines NAME, a
# stilb_scene_function (scene_function.h). NAME: letters, digits and _. Needs glslc. The global property STILB_SHADERS is the
# folder of Stilb's shaders, STILB_SHADERS_NUMBER their stilb_scene_function_shaders().
function(stilb_surface target name file)
	find_program(STILB_GLSLC glslc REQUIRED) # on Debian: apt install glslc
	get_property(shaders GLOBAL PROPERTY STILB_SHADERS)
	get_property(shaders_number GLOBAL PROPERTY STILB_SHADERS_NUMBER)
	if(NOT name MATCHES "^[A-Za-z_][A-Za-z0-9_]*$" OR name MATCHES "^................................................................")
		message(FATAL_ERROR "stilb_surface: '${name}' is not 1 to 63 letters, digits and _, of which the first is no digit")
	endif()
	get_filename_component(file ${file} ABSOLUTE)
	get_filename_component(file_name ${file} NAME)
	get_filename_component(file_folder ${file} DIRECTORY)
	if(file_name STREQUAL surface_function.glsl)
		message(FATAL_ERROR "stilb_surface: give ${file} another name; Stilb's shaders include a file of this one")
	endif()
	set(folder ${CMAKE_CURRENT_BINARY_DIR}/stilb_surfaces/${target})
	# In the order of render_function_kind, of each kind the last word counts fastest: layers, gloss, coverage, extras.
	set(codes)
	foreach(layers "" "MAPS_LAYERS")
		foreach(gloss "" "LIT_GLOSS")
			foreach(coverage "" "MAPS_COVERAGE")
				foreach(extras "" "MESH_EXTRAS")
					list(APPEND codes "${layers} ${gloss} ${coverage} ${extras}")
				endforeach()
			endforeach()
		endforeach()
	endforeach()
	foreach(gloss "" "LIT_GLOSS")
		foreach(extras "" "MESH_EXTRAS")
			list(APPEND codes "MAPS_LAYERS MAPS_THROUGH ${gloss} ${extras}")
		endforeach()
	endforeach()
	foreach(coverage "" "MAPS_COVERAGE")
		foreach(extras "" "MESH_EXTRAS")
			list(APPEND codes "MESH_CHANNEL ${coverage} ${extras}")
		endforeach()
	endforeach()
	foreach(layers "" "MAPS_LAYERS")
		foreach(extras "" "MESH_EXTRAS")
			list(APPEND codes "MAPS_DEPTH ${layers} ${extras}")
		endforeach()
	endforeach()
	foreach(layers "" "MAPS_LAYERS")
		foreach(extras "" "MESH_EXTRAS")
			list(APPEND codes "MAPS_DEPTH MESH_VELOCITY ${layers} ${extras}")
		endforeach()
	endforeach()
	foreach(layers "" "MAPS_LAYERS")
		foreach(extras "" "MESH_EXTRAS")
			list(APPEND codes "MAPS_DEPTH MESH_VELOCITY MESH_SEEN ${layers} ${extras}")
		endforeach()
	endforeach()
	# The shaders include surface_function.glsl, which includes the program's file, so that errors name its lines. glslc opens no
	# absolute path.
	file(CONFIGURE OUTPUT ${folder}/${name}/surface_function.glsl CONTENT "#include \"${file_name}\"\n" @ONLY)
	set(arrays)
	# glslc writes what a shader was made from with blanks as they are, which no build system understands.
	set(depfile "DEPFILE;@output@.d")
	if("${shaders}${file}${folder}" MATCHES " ")
		set(depfile "")
	endif()
	set(table)
	set(number 0)
	foreach(code ${codes})
		separate_arguments(words UNIX_COMMAND "${code}")
		list(TRANSFORM words PREPEND -D)
		set(output ${folder}/${name}/${number}.inc)
		string(REPLACE @output@ ${output} output_depfile "${depfile}")
		add_custom_command(
			OUTPUT ${output}
			COMMAND ${STILB_GLSLC} --target-env=vulkan1.3 -O -Werror -DMAPS_FUNCTION ${words} -I ${folder}/${name} -I ${file_folder}
				-I ${shaders} -mfmt=c -MD -MF ${output}.d -MT ${output} -o ${output} ${shaders}/render/shaders/maps.frag
			DEPENDS ${file} ${folder}/${name}/surface_function.glsl
			${output_depfile}
			COMMENT "Compiling surface function ${name}, ${number}"
			VERBATIM)
		target_sources(${target} PRIVATE ${output})
		string(APPEND arrays "static const uint32_t ${name}_code_${number}[] =\n#include \"${name}/${number}.inc\"\n\t;\n")
		string(APPEND table "\t\t{${name}_code_${number}, sizeof ${name}_code_${number}},\n")
		math(EXPR number "${number} + 1")
	endforeach()
	file(CONFIGURE OUTPUT ${folder}/${name}.surface.h @ONLY CONTENT
"/* Written by stilb_surface() from ${file}. */
#include <stilb/scene_function.h>

${arrays}
static const stilb_scene_function ${name} = {\"${name}\", UINT64_C(0x${shaders_number}),
	{
${table}	}};
")
	target_include_directories(${target} PRIVATE ${folder})
endfunction()
