#!/usr/bin/env bash
# symbols.sh BUILD: checks that the symbols which the libraries libstilb-*.a under BUILD define for the linker begin with
# the prefix of their module: stilb_<prefix>_, or <prefix>_ inside Stilb. Weak symbols are not checked: they are templates
# and inline functions of C++, which all libraries share. Also checks that no library that programs link calls what changes
# the process behind their backs (guest below). Prints one line per violation; exit 1 if any.
set -euo pipefail
export LC_ALL=C
build=$1

# Prints the prefixes of a module.
prefixes_of() {
	case $1 in
	jobs) echo job ;;
	profiler) echo prof ;;
	shading) echo shade ;;
	culling) echo cull ;;
	bench-harness) echo bench gnuplot ;; # with a file of game/cli
	bench-farm-sim) echo farm ;;
	*) echo "$1" ;;
	esac
}

# fits SYMBOL MODULE: succeeds if the symbol begins with a prefix of the module.
fits() {
	local prefix
	for prefix in $(prefixes_of "$2"); do
		[[ $1 != "${prefix}"_* && $1 != stilb_"$prefix"_* ]] || return 0
	done
	# base also defines names that all modules share.
	[[ $2 == base && ($1 == stilb_* || $1 == glsl_*) ]]
}

# Calls that change the process: how it ends, its signals, locale, folder, environment. A program that links Stilb would not
# expect them.
guest='(at|on_|__cxa_at|_|quick_)?exit|at_quick_exit|signal|sigaction|sigprocmask|pthread_sigmask|setlocale|uselocale'
guest+='|f?chdir|umask|putenv|(un)?setenv|clearenv|srand(om)?|fesetround|fesetenv|feenableexcept|prlimit|setrlimit|prctl'
guest+='|pthread_atfork|freopen|dup2'

# may_call MODULE FUNCTION: succeeds for the calls that are right.
may_call() {
	case $1:$2 in
	profiler:sigaction) ;;                            # captures on a signal or a crash, if the program asks for them
	profiler:pthread_sigmask | input:pthread_sigmask | engine:pthread_sigmask) ;; # the masks of their own threads
	window:setlocale) ;;                              # puts back what GLFW changed
	image:__cxa_atexit) ;;                            # static objects of C++
	bench-*:* | sim:*) ;;                             # no program links these
	*) return 1 ;;
	esac
}

mapfile -t archives < <(find "$build" -name 'libstilb-*.a' | sort)
[ ${#archives[@]} -gt 0 ] || { echo "symbols.sh: no libstilb-*.a under $build"; exit 1; }
violations=0
for archive in "${archives[@]}"; do
	name=$(basename "$archive")
	module=${name#libstilb-}
	module=${module%.a}
	# Skips libraries that a build folder keeps of targets that were renamed or removed.
	[ ! -e "$build/build.ninja" ] || grep -qE "^build ([^ ]*/)?$name:" "$build/build.ninja" || continue
	symbols=$(nm --extern-only --defined-only --format=posix "$archive" | awk 'NF >= 3 && $2 !~ /[WwVvu]/ { print $1 }')
	for symbol in $symbols; do
		fits "$symbol" "$module" && continue
		echo "$name: $symbol lacks the prefix $(prefixes_of "$module" | sed 's/ .*//')_"
		violations=$((violations + 1))
	done
	for symbol in $(nm --undefined-only --format=posix "$archive" | awk '$2 == "U" { print $1 }' | grep -xE "$guest" | sort -u); do
		may_call "$module" "$symbol" && continue
		echo "$name: calls $symbol, which changes the process of the program that links it"
		violations=$((violations + 1))
	done
done
[ $violations -eq 0 ] || exit 1
echo "the symbols of ${#archives[@]} libraries carry their prefix"
