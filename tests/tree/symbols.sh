#!/usr/bin/env bash
# symbols.sh BUILD: what the libraries libstilb-*.a under BUILD give to the linker must carry the prefix of their
# module: stilb_<prefix>_ or, inside Stilb, <prefix>_. Prints one line per violation; exit 1 if any.
# Weak symbols are left out: C++ templates and inline functions, shared by name with every other library.
set -euo pipefail
export LC_ALL=C
build=$1

# Where the prefix is not the name of the module.
prefix_of() {
	case $1 in
	jobs) echo job ;;
	profiler) echo prof ;;
	shading) echo shade ;;
	culling) echo cull ;;
	*) echo "$1" ;;
	esac
}

mapfile -t archives < <(find "$build" -name 'libstilb-*.a' | sort)
[ ${#archives[@]} -gt 0 ] || { echo "symbols.sh: no libstilb-*.a under $build"; exit 1; }
violations=0
for archive in "${archives[@]}"; do
	name=$(basename "$archive")
	module=${name#libstilb-}
	prefix=$(prefix_of "${module%.a}")
	symbols=$(nm --extern-only --defined-only --format=posix "$archive" | awk 'NF >= 3 && $2 !~ /[WwVvu]/ { print $1 }')
	for symbol in $symbols; do
		case $prefix:$symbol in
		*:stilb_"$prefix"_* | *:"$prefix"_*) continue ;;
		base:stilb_* | base:glsl_*) continue ;; # the words that all modules share
		esac
		echo "$name: $symbol lacks the prefix stilb_${prefix}_ or ${prefix}_"
		violations=$((violations + 1))
	done
done
[ $violations -eq 0 ] || exit 1
echo "the symbols of ${#archives[@]} libraries carry their prefix"
