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
