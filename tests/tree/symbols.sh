#!/usr/bin/env bash
# symbols.sh BUILD: checks that the symbols which the libraries libstilb-*.a under BUILD define for the linker begin with
# the prefix of their module: stilb_<prefix>_, or <prefix>_ inside Stilb. Weak symbols are not checked: they are templates
# and inline functions of C++, which all libraries share. Prints one line per violation; exit 1 if any.
set -euo pipefail
export LC_ALL=C
build=$1

# Prints the prefixes of a module. The devices of render have prefixes of their own.
prefixes_of() {
	case $1 in
	jobs) echo job ;;
	profiler) echo prof ;;
	shading) echo shade ;;
	culling) echo cull ;;
	render) echo render vulkan null ;;
	bench-harness) echo bench gnuplot ;; # with a file of game/cli
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
done
[ $violations -eq 0 ] || exit 1
echo "the symbols of ${#archives[@]} libraries carry their prefix"
