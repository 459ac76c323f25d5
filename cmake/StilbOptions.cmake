# Options, and the flags that every target of this project shares (interface library stilb-flags).

option(STILB_ENGINE "Build the engine and the stilb program (off: only the jobs and profiler libraries)" ${PROJECT_IS_TOP_LEVEL})
option(STILB_TESTS "Build the tests" ${PROJECT_IS_TOP_LEVEL})
option(STILB_JOBS_EXAMPLES "Build the examples of the jobs library" ${STILB_TESTS}) # the tests run them
option(STILB_PROFILER_EXAMPLES "Build the examples of the profiler library" ${STILB_TESTS}) # likewise
option(STILB_BENCH "Build stilb-bench, the measurements against other libraries" ${STILB_ENGINE})
option(STILB_PARTS "Build what a library starts or loads by itself (importer, module for pictures) with that library" ON)
option(STILB_WERROR "Treat warnings as errors (on in ./dev and CI)" OFF)
option(STILB_HARDENED "Build with the hardening flags of distributions (off for one that passes its own)" ${PROJECT_IS_TOP_LEVEL})
option(STILB_PROFILE "Compile the PROFILE macros in" ON)
set(STILB_SANITIZE "" CACHE STRING "Sanitizers to build with, the value of -fsanitize= (address,undefined or thread)")

if(STILB_SANITIZE) # sanitizers check more than hardening does, and wrap the same calls
	set(STILB_HARDENED OFF)
endif()

if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
	set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

if(PROJECT_IS_TOP_LEVEL)
	set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}) # programs are build/release/stilb and so on
endif()
set(CMAKE_C_STANDARD 17)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS ON)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_C_VISIBILITY_PRESET hidden)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)

add_library(stilb-flags INTERFACE)
target_compile_definitions(stilb-flags INTERFACE _GNU_SOURCE)
# gcc and clang would contract different expressions into fused multiply-adds, and pictures are compared bit by bit.
# Public functions are exported by the shared library, but nobody replaces them: within a file they are called directly.
target_compile_options(stilb-flags INTERFACE -fno-semantic-interposition -ffp-contract=off -Wall -Wextra -Wshadow
	$<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes -Wdouble-promotion>
	$<$<BOOL:${STILB_WERROR}>:-Werror>)
# A program loads only the libraries that it uses: the tests of the null device load neither Vulkan nor GLFW.
target_link_options(stilb-flags INTERFACE -Wl,--as-needed)

# ---- hardening: the flags of distributions; tests/install/hardening.sh checks the results ----
if(STILB_HARDENED)
	include(CheckPIESupported)
	check_pie_supported() # lets CMake link programs as position independent, too
	target_compile_options(stilb-flags INTERFACE -fstack-protector-strong -fstack-clash-protection)
	if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
		target_compile_options(stilb-flags INTERFACE -fcf-protection)
	endif()
	# The checked calls of the C library (FORTIFY) need optimisation.
	target_compile_options(stilb-flags INTERFACE $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2>)
	target_link_options(stilb-flags INTERFACE -Wl,-z,relro,-z,now,-z,noexecstack)
endif()

# stilb_hot(FILE...): takes stack protector and stack clash protection away from files whose functions run for nanoseconds
# and handle only our own numbers and pointers, never bytes from outside. A canary a call and a probe a page of stack would
# be measurable there, and protect nothing. All other hardening stays.
#
# Their loops begin a cache line. A loop of a few instructions that happens to lie across two lines is slower: the one that
# writes the ids of all models takes 5.8 us instead of 3.9 us for 100,000 models on an EPYC 9004.
function(stilb_hot)
	set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -falign-loops=64)
	if(STILB_HARDENED)
		set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -fno-stack-protector -fno-stack-clash-protection)
	endif()
endfunction()

# stilb_brief(TARGET...): programs and libraries whose own code runs for moments. The build with the address sanitizer does not
# optimise them: clang compiles them in a third of the time, and the sanitizers see all accesses of the source.
function(stilb_brief)
	if(STILB_SANITIZE MATCHES address)
		foreach(target ${ARGN})
			target_compile_options(${target} PRIVATE -O0)
		endforeach()
	endif()
endfunction()

if(STILB_SANITIZE)
	target_compile_options(stilb-flags INTERFACE -fsanitize=${STILB_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
	target_link_options(stilb-flags INTERFACE -fsanitize=${STILB_SANITIZE})
	# Hundreds of programs contain a sanitizer's runtime. LLVM's linker takes a third of the time.
	find_program(STILB_LLD NAMES ld.lld)
	if(STILB_LLD)
		target_link_options(stilb-flags INTERFACE -fuse-ld=lld)
	endif()
	# Our C programs load C++ code: drivers, and the module for pictures. clang keeps the C++ part of its sanitizer runtimes
	# in libraries of their own.
	if(CMAKE_C_COMPILER_ID MATCHES Clang)
		target_link_options(stilb-flags INTERFACE -fsanitize-link-c++-runtime)
		target_link_libraries(stilb-flags INTERFACE stdc++)
	endif()
endif()
if(STILB_SANITIZE MATCHES address)
	# Linked into programs only, and exported, so that shared libraries which they open call it too.
	add_library(stilb-dlclose OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/tests/support/dlclose_noop.c)
	target_link_libraries(stilb-dlclose PRIVATE stilb-flags)
	target_sources(stilb-flags INTERFACE
		$<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:$<TARGET_OBJECTS:stilb-dlclose>>)
	target_link_options(stilb-flags INTERFACE $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:LINKER:--export-dynamic-symbol=dlclose>)
endif()
