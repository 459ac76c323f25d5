#!/usr/bin/env bash
# Runs a copy of ./dev among stand-ins for dpkg-query, apt-get, sudo, id, cmake, ctest and Xvfb, and checks what it
# calls, what it prints and how it exits. Nothing is installed or built.
set -uo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
calls=$scratch/calls
failures=0

fail() {
	printf '%s\n' "$test: $*" "--- stdout" "$(cat "$scratch/out")" "--- stderr" "$(cat "$scratch/err")" "--- calls" "$(cat "$calls")"
	failures=$((failures + 1))
}

stand_in() { # NAME SCRIPT: a command that writes down its call and then runs SCRIPT
	printf '#!/bin/bash\necho "%s $*" >>"%s"\n%s\n' "$1" "$calls" "$2" >"$scratch/bin/$1"
	chmod +x "$scratch/bin/$1"
}

# A project folder with the real ./dev, where all packages are installed and all tests pass.
fresh_project() {
	test=$1
	rm -rf "${scratch:?}"/{bin,project}
	mkdir -p "$scratch"/{bin,project/build/release,project/tests/{gi,jobs,profiler,vm,tree}}
	touch "$scratch"/project/tests/{gi,jobs,profiler,vm}/CMakeLists.txt
	cp "$source/dev" "$source/packages.txt" "$scratch/project"
	local tool
	for tool in awk bash cat chmod cut dirname env grep mkdir mkfifo mktemp nice nproc paste renice rm sed setarch sleep tail true xargs; do
		ln -s "$(command -v "$tool")" "$scratch/bin/$tool"
	done
	awk '!/^#/ && NF { print "installed", $2 }' "$source/packages.txt" >"$scratch/installed"
	stand_in dpkg-query "cat '$scratch/installed'"
	stand_in apt-get ''
	stand_in id 'echo 0'
	stand_in cmake 'echo progress'
	stand_in Xvfb "echo \$\$ >'$scratch/display-server'; echo 7 >&3; exec sleep 60"
	rm -f "$scratch"/junit-*
	stand_in ctest '
		case $* in
		*--print-labels*) printf "All Labels:\n  unit\n  device\n  window\n  tsan\n"; exit 0 ;;
		esac
		build=; label=; junit=
		while [ $# -gt 0 ]; do
			case $1 in --test-dir) build=${2##*/} ;; -L) label=$2 ;; --output-junit) junit=$2 ;; esac
			shift
		done
		label=${label//[^a-z]/}
		echo "display for $build $label: ${DISPLAY-none}"
		file='"$scratch"'/junit-$build-$label
		[ -f "$file" ] || file='"$scratch"'/junit-good
		cat "$file" >"$junit"
		! grep -q "status=\"fail\"\|Unable" "$file"'
	junit good 'test_a run' 'test_b run'
	stand_in analyze.sh 'echo nothing found in 50 files'
	mv "$scratch/bin/analyze.sh" "$scratch/project/tests/tree"
	stand_in stilb 'echo stilb ran'
	stand_in stilb-bench 'echo stilb-bench ran'
	mv "$scratch/bin/stilb" "$scratch/bin/stilb-bench" "$scratch/project/build/release"
	: >"$calls"
}

# Writes the results that the stand-in for ctest reports for NAME, a build and a label. To ctest, both skip (the test
# asked for it) and gone (its program is missing) are "notrun".
junit() { # NAME 'TEST STATUS'...
	local file=$scratch/junit-$1 name status
	shift
	printf '<?xml version="1.0"?>\n<testsuite name="x"\n\ttests="2"\n\t>\n' >"$file"
	while read -r name status; do
		case $status in
		run) printf '\t<testcase name="%s" classname="c" time="0" status="run">\n\t\t<system-out>fine\n</system-out>\n' "$name" ;;
		fail) printf '\t<testcase name="%s" classname="c" time="0" status="fail">\n\t\t<failure message=""/>\n\t\t<system-out>bad\n</system-out>\n' "$name" ;;
		skip) printf '\t<testcase name="%s" classname="c" time="0" status="notrun">\n\t\t<skipped message="SKIP_RETURN_CODE=77"/>\n\t\t<system-out>noise\nskipped: no driver here\n</system-out>\n' "$name" ;;
		gone) printf '\t<testcase name="%s" classname="c" time="0" status="notrun">\n\t\t<skipped message="Unable to find executable"/>\n\t\t<system-out>Unable to find executable: x</system-out>\n' "$name" ;;
		esac
		printf '\t</testcase>\n'
	done < <(printf '%s\n' "$@") >>"$file"
	echo '</testsuite>' >>"$file"
}

dev() { # EXPECTED-EXIT ARGS...: runs the copy of ./dev
	local wanted=$1 status
	shift
	(cd "$scratch" && env -i PATH="$scratch/bin" ${require:+STILB_REQUIRE="$require"} "$scratch/project/dev" "$@") \
		>"$scratch/out" 2>"$scratch/err" </dev/null
	status=$?
	[ $status -eq "$wanted" ] || fail "exit status $status, not $wanted"
}

called() { # LINE: one of the calls written down is exactly LINE
	grep -qxF -- "$1" "$calls" || fail "was not called: $1"
}

not_called() { # START: no call written down begins with START
	! grep -q -- "^$1" "$calls" || fail "was called: $1"
}

prints() { # out|err LINE: the exact line is there
	grep -qxF -- "$2" "$scratch/$1" || fail "std$1 lacks the line: $2"
}

last_line() {
	[ "$(tail -n 1 "$scratch/out")" = "$1" ] || fail "the last line is not: $1"
}

ends() { # FILE WORDS: waits for the process whose number is in FILE; if it does not end, fails with the words
	local tries=0
	while kill -0 "$(cat "$1")" 2>/dev/null && [ $((tries += 1)) -le 50 ]; do
		sleep 0.1
	done
	[ $tries -le 50 ] || fail "$2"
}

remove_package() {
	sed -i "/ $1\$/d" "$scratch/installed"
}

test_refuses_before_anything_else() {
	local arguments
	for arguments in frobnicate '--wrong' 'test --quik' 'test --quick more' 'test gi --quick' 'test nothing' \
		'test gi nothing' 'build x' 'fmt x' 'lint x' ''; do
		fresh_project "refuses '$arguments'"
		# shellcheck disable=SC2086
		dev 2 $arguments
		[ ! -s "$calls" ] || fail "something was called"
		[ ! -s "$scratch/out" ] || fail "something is on stdout"
	done
	fresh_project help
	dev 0 help
	grep -q '^usage: ./dev' "$scratch/out" || fail "no usage"
	[ ! -s "$calls" ] || fail "something was called"
}

test_set_up() {
	local update="apt-get update"
	local install="apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=300"

	fresh_project "nothing is missing"
	dev 0 build
	not_called apt-get
	called "cmake --build --preset release"

	fresh_project "root installs what is missing, and no more"
	remove_package glslc
	remove_package cmake
	remove_package xvfb
	dev 0 build
	called "$update"
	called "$install cmake glslc"

	fresh_project "tests need more"
	remove_package xvfb
	dev 0 test
	called "$install xvfb"

	fresh_project "an unpacked package is not an installed one"
	sed -i 's/^installed glslc$/half-configured glslc/' "$scratch/installed"
	dev 0 build
	called "$install glslc"

	fresh_project "a user installs with sudo"
	remove_package glslc
	stand_in id 'echo 1000'
	stand_in sudo '"$@"'
	dev 0 build
	called "sudo env DEBIAN_FRONTEND=noninteractive $install glslc"

	fresh_project "neither root nor sudo"
	remove_package glslc
	stand_in id 'echo 1000'
	dev 1 build
	prints err "  env DEBIAN_FRONTEND=noninteractive $install glslc"
	not_called apt-get
	not_called cmake

	fresh_project "no network"
	remove_package glslc
	stand_in apt-get 'exit 100'
	dev 1 demo
	prints err "  env DEBIAN_FRONTEND=noninteractive $install glslc"
	not_called cmake

	fresh_project "not Debian"
	rm "$scratch/bin/dpkg-query" "$scratch/bin/apt-get"
	dev 1 build
	grep -q "^  env .*$install .*libvulkan-dev" "$scratch/err" || fail "the command is not printed"

	fresh_project "--no-install, wherever it stands"
	rm "$scratch/bin/dpkg-query"
	dev 0 build --no-install
	dev 0 --no-install demo
	called "cmake --build --preset release"
}

test_demo() {
	fresh_project demo
	dev 0 demo --models 5 --title 'two words' --no-install
	called "stilb demo --screenshot stilb-demo.png --trace stilb-demo.trace.json --models 5 --title two words"
	[ "$(cat "$scratch/out")" = "stilb ran" ] || fail "something else is on stdout"
	called "cmake --preset release $options -DSTILB_TESTS=OFF"

	fresh_project "demo when tests were built before"
	touch "$scratch/project/build/release/CMakeCache.txt"
	dev 0 demo
	called "cmake --preset release $options"

	fresh_project "demo when the build fails"
	stand_in cmake 'exit 1'
	dev 1 demo
	not_called stilb
	not_called "cmake --build"
}

test_bench() {
	fresh_project bench
	remove_package libck-dev
	remove_package clang-format
	dev 0 bench queue --only 'two words' --no-install
	called "stilb-bench queue --only two words"
	[ "$(cat "$scratch/out")" = "stilb-bench ran" ] || fail "something else is on stdout"
	not_called apt-get
	dev 0 bench --help
	called "apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=300 libck-dev"
	called "stilb-bench --help"

	fresh_project "bench when the build fails"
	stand_in cmake 'exit 1'
	dev 1 bench queue
	not_called stilb-bench
}

test_compiler_cache() {
	fresh_project "the compiler cache, where there is one"
	stand_in ccache ''
	dev 0 build
	called "cmake --preset release ${options//LAUNCHER=/LAUNCHER=$scratch/bin/ccache} -DSTILB_TESTS=OFF"
}

test_modules() {
	fresh_project "two modules"
	dev 0 test gi profiler
	called "cmake --preset release $options -DSTILB_TESTS=ON"
	called "cmake --build --preset release --target stilb-tests-gi stilb-tests-profiler"
	grep -qE -- '^ctest .*/build/release .* -L \^module=gi\$$' "$calls" || fail "the tests of gi did not run"
	grep -q '^profiler  passed   2 passed, ' "$scratch/out" || fail "no line for the module"
	prints out "display for release modulegi: :7"
	last_line "4 passed, 0 failed, 0 skipped"
	not_called "cmake --preset clang"

	fresh_project "a module that does not build"
	stand_in cmake '[ "$1" = --preset ]'
	dev 1 test gi
	not_called ctest
	last_line "0 passed, 1 failed, 0 skipped"

	fresh_project "the module vm fetches its kernel"
	stand_in kernel.sh ''
	mv "$scratch/bin/kernel.sh" "$scratch/project/tests/vm"
	dev 0 test vm
	called "kernel.sh $scratch/project/build/vm-kernel"
}

test_fmt() {
	fresh_project fmt
	remove_package clang-format
	stand_in clang-format ''
	printf '#!/bin/bash\nprintf "%%s\\n" a.c notes.md b/c.h "b/with space.cpp"\n' >"$scratch/project/tests/tree/files.sh"
	chmod +x "$scratch/project/tests/tree/files.sh"
	dev 0 fmt
	called "apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=300 clang-format"
	called "clang-format -i a.c b/c.h b/with space.cpp"
	stand_in clang-format 'exit 1'
	dev 123 fmt
}

test_summary() {
	fresh_project "all good"
	dev 0 test
	last_line "14 passed, 0 failed, 0 skipped"
	prints out "display for release window: :7"
	ends "$scratch/display-server" "the display server still runs"
	local preset
	for preset in release clang asan tsan arm64; do
		called "cmake --preset $preset $options -DSTILB_TESTS=ON"
	done
	called "cmake --build --preset asan"
	called "cmake --build --preset clang --target$(printf ' stilb-tests-%s' jobs profiler base shading numeric culling light render gi)"
	! grep -qE '^(model|truth|viewer|fuzz)' "$scratch/out" || fail "a tier without tests is in the summary"

	grep -q -- '^ctest .*/build/asan .* -LE ^fuzz\$$' "$calls" || fail "the fuzzers run twice"

	! grep -q '^analyze' "$scratch/out" || fail "analysed without a build"

	fresh_project "the code is analysed"
	touch "$scratch/project/build/release/compile_commands.json"
	dev 0 test
	grep -q "^analyze.sh $scratch/project/build/release .*/analyze-yields\$" "$calls" || fail "not analysed"
	grep -q '^analyze   passed   nothing found in 50 files, ' "$scratch/out" || fail "no line for the tier"
	last_line "15 passed, 0 failed, 0 skipped"
	local end
	for end in 1 77; do
		stand_in analyze.sh "echo a finding; exit $end"
		mv "$scratch/bin/analyze.sh" "$scratch/project/tests/tree"
		[ $end -eq 77 ] || dev 1 test
		[ $end -eq 1 ] || dev 0 test
		require=unit,analyze dev 1 test
		last_line "14 passed, 1 failed, 0 skipped"
	done

	fresh_project "the analysis yields to the tests, and after them no more"
	touch "$scratch/project/build/release/compile_commands.json"
	stand_in analyze.sh "
		[ -e \"\$2\" ] || exit 1
		for try in {1..500}; do [ -e \"\$2\" ] || exit 0; sleep 0.01; done
		exit 1"
	mv "$scratch/bin/analyze.sh" "$scratch/project/tests/tree"
	dev 0 test
	last_line "15 passed, 0 failed, 0 skipped"

	fresh_project "the analysis ends with the rest"
	touch "$scratch/project/build/release/compile_commands.json"
	rm -f "$scratch/analyzer"
	stand_in analyze.sh "echo \$\$ >$scratch/analyzer; exec sleep 100"
	mv "$scratch/bin/analyze.sh" "$scratch/project/tests/tree"
	stand_in ctest "[[ \$* != *--print-labels* ]] || exit 0; until [ -s $scratch/analyzer ]; do sleep 0.01; done; kill \$PPID"
	dev 143 test
	ends "$scratch/analyzer" "the analysis still runs"

	fresh_project "builds go on while tests run"
	stand_in ctest "
		case \$* in *--print-labels*) echo '  unit' ; exit 0 ;; esac
		tries=0
		until grep -q '^cmake --build --preset arm64' '$calls' || [ \$((tries += 1)) -gt 500 ]; do sleep 0.01; done
		[ \$tries -le 500 ] || exit 1
		while [ \$# -gt 0 ]; do [ \$1 != --output-junit ] || cat '$scratch/junit-good' >\"\$2\"; shift; done"
	dev 0 test
	last_line "10 passed, 0 failed, 0 skipped"

	fresh_project "the builds end with the rest"
	rm -f "$scratch/building"
	stand_in cmake "[[ \$* != '--build --preset clang '* ]] || { echo \$\$ >$scratch/building; exec sleep 100; }"
	stand_in ctest "[[ \$* != *--print-labels* ]] || { echo '  unit'; exit 0; }
		until [ -s $scratch/building ]; do sleep 0.01; done; kill \$PPID"
	dev 143 test
	ends "$scratch/building" "a build still runs"

	fresh_project "the first build fails"
	stand_in cmake '[ "$2" != release ]'
	dev 1 test
	grep -q '^unit      failed   the build release failed' "$scratch/out" || fail "no line for the tier"
	last_line "8 passed, 7 failed, 0 skipped"

	fresh_project quick
	dev 0 test --quick
	last_line "2 passed, 0 failed, 0 skipped"
	not_called "cmake --preset clang"
	not_called Xvfb

	fresh_project "one failure"
	junit release-device 'test_a run' 'test_bad fail' 'test_gone gone'
	dev 1 test
	grep -q '^device    failed   1 passed, failed: test_bad test_gone, ' "$scratch/out" || fail "no line for the tier"
	last_line "13 passed, 2 failed, 0 skipped"

	fresh_project "a skip"
	junit release-device 'test_a skip'
	dev 0 test
	grep -q '^device    skipped  0 passed, skipped: test_a (no driver here), ' "$scratch/out" || fail "no line for the tier"
	last_line "12 passed, 0 failed, 1 skipped"

	fresh_project "a skip where none is allowed"
	junit release-device 'test_a skip' 'test_b run'
	require=unit,device dev 1 test
	grep -q '^device    failed ' "$scratch/out" || fail "no line for the tier"
	last_line "13 passed, 1 failed, 0 skipped"

	fresh_project "a required tier without tests"
	junit release-model
	require=model dev 1 test
	grep -q '^model     failed ' "$scratch/out" || fail "no line for the tier"

	fresh_project "the tier vm fetches its kernel"
	stand_in kernel.sh 'exit 1'
	mv "$scratch/bin/kernel.sh" "$scratch/project/tests/vm"
	require=vm dev 0 test
	called "kernel.sh $scratch/project/build/vm-kernel"
	grep -q '^vm        passed ' "$scratch/out" || fail "without a kernel the tests cannot say why they are skipped"
	: >"$calls"
	require=vm dev 0 test --no-install
	not_called kernel.sh

	fresh_project "a build that fails"
	stand_in cmake '[ "$2" != asan ]'
	dev 1 test
	grep -q '^asan      failed   the build asan failed' "$scratch/out" || fail "no line for the tier"
	grep -q '^fuzz      failed   the build asan failed' "$scratch/out" || fail "no line for the tier"
	last_line "12 passed, 2 failed, 0 skipped"

	fresh_project "without Xvfb"
	rm "$scratch/bin/Xvfb"
	dev 0 test --no-install
	prints out "display for release window: none"

	fresh_project "Xvfb that does not start"
	stand_in Xvfb 'echo no such screen; exit 1'
	dev 0 test
	prints out "display for release window: none"
	prints err "no such screen"
}

# Packages are listed once each, in a group that ./dev knows, with a reason.
test_packages() {
	test=packages.txt
	: >"$scratch/out"
	: >"$scratch/err"
	: >"$calls"
	local wrong
	wrong=$(awk '/^#/ || !NF { next } NF < 3 || $1 !~ /^(build|unit|test|lint|bench)$/ || seen[$2]++' "$source/packages.txt")
	[ -z "$wrong" ] || fail "these rows are wrong: $wrong"
}

# The options that ./dev gives to cmake if no compiler cache is installed.
options="-DSTILB_WERROR=ON -DCMAKE_C_COMPILER_LAUNCHER= -DCMAKE_CXX_COMPILER_LAUNCHER="
require=
test_refuses_before_anything_else
test_set_up
test_demo
test_bench
test_compiler_cache
test_modules
test_fmt
test_summary
test_packages
[ $failures -eq 0 ] || { echo "$failures failed"; exit 1; }
echo "./dev does what it says"
