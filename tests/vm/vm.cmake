# Tests with a real kernel: boot.sh runs the programs in a virtual machine. Where there is no kernel (kernel.sh), no
# QEMU or no busybox they are skipped and say why. They measure time: nothing else runs beside them.
if(STILB_SANITIZE OR NOT TARGET stilb-input)
	return() # sanitizers are for the tests with umockdev; here a virtual CPU has enough to do
endif()
set(STILB_VM_KERNEL ${PROJECT_SOURCE_DIR}/build/vm-kernel CACHE PATH "Where tests/vm/kernel.sh has put the kernel for tests")

# vm_program(NAME SOURCES... [LIBS ...])
function(vm_program name)
	cmake_parse_arguments(arg "" "" "LIBS" ${ARGN})
	add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
	target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/engine ${PROJECT_SOURCE_DIR}/tests)
	target_link_libraries(${name} PRIVATE stilb-flags stilb-input ${arg_LIBS})
	target_compile_options(${name} PRIVATE -UNDEBUG)
	add_dependencies(stilb-tests ${name})
endfunction()

set(room input_descriptors.c vm/uhid_pad.c vm/vm_room.c)
vm_program(test_vm_pads vm/test_vm_pads.c ${room} LIBS PkgConfig::cmocka)
vm_program(test_vm_usb vm/test_vm_usb.c ${room} LIBS PkgConfig::cmocka)
vm_program(test_vm_storm vm/test_vm_storm.c ${room} LIBS PkgConfig::cmocka)
pkg_check_modules(vm_hidapi REQUIRED IMPORTED_TARGET hidapi-hidraw)
vm_program(vm_subject vm/vm_subject.c LIBS PkgConfig::vm_hidapi)
# One boot for all: it is a quarter of the time.
add_test(NAME test_input_vm COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/vm/boot.sh ${STILB_VM_KERNEL}
	${CMAKE_CURRENT_BINARY_DIR}/test_input_vm.log $<TARGET_FILE:test_vm_pads> && $<TARGET_FILE:test_vm_usb> &&
	$<TARGET_FILE:test_vm_storm> 40 $<TARGET_FILE:vm_subject>)
stilb_test_properties(test_input_vm 300 vm)
set_tests_properties(test_input_vm PROPERTIES RUN_SERIAL TRUE)
# By hand, a thousand cycles: cmake --build --preset release --target soak-pads
add_custom_target(soak-pads COMMAND ${CMAKE_COMMAND} -E env STILB_VM_SECONDS=1800
	${CMAKE_CURRENT_SOURCE_DIR}/vm/boot.sh ${STILB_VM_KERNEL} ${CMAKE_CURRENT_BINARY_DIR}/soak_pads.log
	$<TARGET_FILE:test_vm_storm> 1000 $<TARGET_FILE:vm_subject> DEPENDS test_vm_storm vm_subject USES_TERMINAL)
stilb_check(test_vm_scripts COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/vm/test_scripts.sh)
# The same, --target soak-descriptors: how the kernel reads descriptors, and how we do.
vm_program(soak_vm_descriptor vm/soak_vm_descriptor.c ${room} LIBS PkgConfig::cmocka)
add_custom_target(soak-descriptors COMMAND ${CMAKE_COMMAND} -E env STILB_VM_SECONDS=1800
	${CMAKE_CURRENT_SOURCE_DIR}/vm/boot.sh ${STILB_VM_KERNEL} ${CMAKE_CURRENT_BINARY_DIR}/soak_descriptors.log
	$<TARGET_FILE:soak_vm_descriptor> 500 DEPENDS soak_vm_descriptor USES_TERMINAL)
