#!/usr/bin/env bash
# hardening.sh COMPILE-COMMANDS FILE...: fails unless each program or module FILE is hardened (STILB_HARDENED in
# cmake/StilbOptions.cmake), as its ELF headers say, and unless all code outside tests/ was compiled with the flags that
# leave no trace there: COMPILE-COMMANDS is CMake's compile_commands.json. (Debian 12's start-up code has no mark for
# -fcf-protection, so no program has it.)
set -uo pipefail
commands=$1
shift
failures=0

lacks() { # FILE TEXT
	printf '%s: %s\n' "$1" "$2"
	failures=$((failures + 1))
}

for file; do
	headers=$(readelf --wide --file-header --program-headers "$file")
	dynamic=$(readelf --wide --dynamic "$file")
	grep -q 'DYN ' <<<"$headers" || lacks "$file" "not position independent"
	grep -q 'GNU_RELRO' <<<"$headers" || lacks "$file" "its relocations stay writable (-z relro)"
	grep -q 'BIND_NOW\|Flags:.* NOW' <<<"$dynamic" || lacks "$file" "calls of libraries are resolved late (-z now)"
	! grep -q 'TEXTREL\|RPATH\|RUNPATH' <<<"$dynamic" || lacks "$file" "relocations in code, or a search path of its own"
	grep -q 'GNU_STACK.* RW ' <<<"$headers" || lacks "$file" "its stack is executable (-z noexecstack)"
	! grep -q 'LOAD.* RWE ' <<<"$headers" || lacks "$file" "memory that is both writable and executable"
	grep -q '__stack_chk_fail' <<<"$(readelf --wide --dyn-syms "$file")" ||
		lacks "$file" "no canaries on the stack (-fstack-protector-strong)"
done

# One line for each file that is compiled.
compiled=$(grep '"command": .* -c ' "$commands" | grep -v ' -c [^ ]*/tests/')
[ -n "$compiled" ] || lacks "$commands" "no commands"
flags="-fstack-protector-strong -fstack-clash-protection -D_FORTIFY_SOURCE=2"
[[ $headers != *X86-64* ]] || flags+=" -fcf-protection"
for flag in $flags; do
	without=$(grep -v -- " $flag " <<<"$compiled")
	[ -z "$without" ] || lacks "$commands" "compiled without $flag: $(sed 's/.* -c //' <<<"$without" | paste -sd ' ')"
done
# The hot files are compiled without canaries on the stack. Code that reads files, devices or arguments must not be
# among them.
outside=$(grep -- ' -fno-stack-protector ' <<<"$compiled" | grep -E ' -c [^ ]*/(game|engine/(base|image|input|scene|window))/')
[ -z "$outside" ] || lacks "$commands" "hot, but reads what comes from outside: $(sed 's/.* -c //' <<<"$outside" | paste -sd ' ')"

[ $failures -eq 0 ] || exit 1
echo "$# programs and modules are hardened"
