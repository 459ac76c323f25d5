#!/usr/bin/env bash
# symbols.sh BUILD: what the libraries libstilb-*.a under BUILD give to the linker must carry the prefix of their
# module: stilb_<prefix>_ or, inside Stilb, <prefix>_. Prints one line per violation; exit 1 if any.
# Weak symbols are left out: C++ templates and inline functions, shared by name with every other library.
set -euo pipefail
export LC_ALL=C
build=$1

# Where the prefix is not the name of the module. The devices of render have their own beside it.
prefixes_of() {
	case $1 in
	jobs) echo job ;;
	profiler) echo prof ;;
	shading) echo shade ;;
	culling) echo cull ;;
	render) echo render vulkan null ;;
	*) echo "$1" ;;
	esac
}

# fits SYMBOL MODULE
fits() {
	local prefix
	for prefix in $(prefixes_of "$2"); do
		[[ $1 != "${prefix}"_* && $1 != stilb_"$prefix"_* ]] || return 0
	done
	# base has the words that all modules share.
	[[ $2 == base && ($1 == stilb_* || $1 == glsl_*) ]]
}

mapfile -t archives < <(find "$build" -name 'libstilb-*.a' | sort)
[ ${#archives[@]} -gt 0 ] || { echo "symbols.sh: no libstilb-*.a under $build"; exit 1; }
violations=0
for archive in "${archives[@]}"; do
	name=$(basename "$archive")
	module=${name#libstilb-}
	module=${module%.a}
	symbols=$(nm --extern-only --defined-only --format=posix "$archive" | awk 'NF >= 3 && $2 !~ /[WwVvu]/ { print $1 }')
	for symbol in $symbols; do
		fits "$symbol" "$module" && continue
		echo "$name: $symbol lacks the prefix $(prefixes_of "$module" | sed 's/ .*//')_"
		violations=$((violations + 1))
	done
done
[ $violations -eq 0 ] || exit 1
echo "the symbols of ${#archives[@]} libraries carry their prefix"
