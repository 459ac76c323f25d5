# The mutation check of shade/README.md: the tests with proofs, built once more with every literal of the shading headers a
# variable. Included after the tests of shading and gi, which it looks through.

if(STILB_SANITIZE OR NOT STILB_ENGINE)
	return()
endif()

# stilb_mutants(NAME HEADERS): a target that changes the headers of a folder: NAME/shading and NAME/list in the build folder.
function(stilb_mutants name headers)
	set(folder ${CMAKE_CURRENT_BINARY_DIR}/${name})
	file(GLOB sources CONFIGURE_DEPENDS ${headers}/*.h)
	list(TRANSFORM sources REPLACE ".*/" ${folder}/shading/ OUTPUT_VARIABLE changed)
	add_custom_command(OUTPUT ${folder}/list ${changed}
		COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/shade/mutants.sh ${headers} ${folder}/shading ${folder}/list
		DEPENDS ${sources} shade/mutants.sh shade/mutants.awk shade/mutant.h
		VERBATIM)
	add_custom_target(${name} DEPENDS ${folder}/list)
endfunction()

# stilb_mutant(NAME MUTANTS): makes the library or program NAME see the changed headers.
function(stilb_mutant name mutants)
	set(folder ${CMAKE_CURRENT_BINARY_DIR}/${mutants})
	add_dependencies(${name} ${mutants})
	target_include_directories(${name} BEFORE PRIVATE ${folder} ${folder}/shading ${PROJECT_SOURCE_DIR}
		${PROJECT_SOURCE_DIR}/engine ${CMAKE_CURRENT_SOURCE_DIR})
	target_link_libraries(${name} PRIVATE stilb-flags)
	target_compile_options(${name} PRIVATE -UNDEBUG -O1 -w -include ${CMAKE_CURRENT_SOURCE_DIR}/shade/mutant.h)
endfunction()

stilb_mutants(mutants ${PROJECT_SOURCE_DIR}/engine/shading)

# What the proofs ask of gi is made of the changed headers too: it is found before the real library.
get_target_property(sources stilb-gi SOURCES)
list(FILTER sources INCLUDE REGEX "gi_(albedo|catalog|quadrature|sh|vmf)\\.c$")
list(TRANSFORM sources PREPEND ${PROJECT_SOURCE_DIR}/engine/gi/)
add_library(mutant_gi STATIC EXCLUDE_FROM_ALL ${sources})
stilb_mutant(mutant_gi mutants)

# Every test that keeps to the two groups of support/shade_proof.h.
get_directory_property(tests BUILDSYSTEM_TARGETS)
list(FILTER tests INCLUDE REGEX "^test_(shade|gi)_")
set(programs)
foreach(test ${tests})
	if(NOT EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${test}.c)
		continue()
	endif()
	file(STRINGS ${test}.c proof REGEX "return SHADE_PROOF_RUN")
	if(proof)
		get_target_property(libraries ${test} LINK_LIBRARIES)
		add_executable(mutant_${test} ${test}.c shade/mutant.c)
		target_link_libraries(mutant_${test} PRIVATE mutant_gi ${libraries})
		stilb_mutant(mutant_${test} mutants)
		add_dependencies(stilb-tests mutant_${test})
		list(APPEND programs $<TARGET_FILE:mutant_${test}>)
	endif()
endforeach()
add_test(NAME test_shade_mutation
	COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/shade/mutate.sh ${CMAKE_CURRENT_BINARY_DIR}/mutants/list ${programs})
stilb_test_properties(test_shade_mutation 300 model)

# The check itself: literals that no test proves, planted in a header of their own.
stilb_mutants(planted ${CMAKE_CURRENT_SOURCE_DIR}/shade/planted)
add_executable(mutant_planted shade/planted.c shade/mutant.c)
stilb_mutant(mutant_planted planted)
target_link_libraries(mutant_planted PRIVATE m)
add_dependencies(stilb-tests mutant_planted)
stilb_check(test_shade_mutation_planted COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/shade/planted.sh
	${CMAKE_CURRENT_BINARY_DIR}/planted/list $<TARGET_FILE:mutant_planted>)
