#!/usr/bin/env bash
# shape.sh [ROOT]: checks on the text of the tree. Prints one line per violation; exit 1 if any.
set -euo pipefail
export LC_ALL=C
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "${1:-$here/../..}"

sources() {
	"$here/files.sh" "$PWD" | grep -E '\.([ch]|cpp|hpp|glsl|vert|frag|comp|sh)$|(^|/)(dev|CMakeLists.txt)$' || true
}

# A longer file is two files.
long_files() {
	sources | while read -r file; do
		lines=$(wc -l <"$file")
		[ "$lines" -le 1500 ] || echo "$file: $lines lines; 1500 is the most"
	done
}

# Every header is guarded by a name of its own. glsl_begin.h and glsl_end.h are meant to be included again and again;
# job_model_sys.h takes the place, and the guard, of jobs/job_sys.h.
header_guards() {
	sources | grep -E '\.hpp$|\.h$' | grep -vE '(^|/)(glsl_(begin|end)|job_model_sys)\.h$' | while read -r file; do
		awk -v file="$file" '
			/^[ \t]*#/ {
				if (++n == 1 && $1 == "#ifndef") guard = $2
				else if (n == 2 && guard != "" && $1 == "#define" && $2 == guard && NF == 2) { print "guard", guard, file; exit }
				else { print "none", file; exit }
			}
			END { if (n == 0) print "none", file }' "$file"
	done | awk '
		$1 == "none" { print $2 ": does not start with a header guard"; next }
		$2 in owner { print $3 ": the header guard " $2 " is also that of " owner[$2]; next }
		{ owner[$2] = $3 }'
}

# The thread sanitizer cannot see a fence: order lives on the atomic itself.
fences() {
	sources | grep -E '\.([chp]|cpp|hpp)$' | while read -r file; do
		grep -nHE 'atomic_(thread|signal)_fence[[:space:]]*\(|__sync_synchronize' "$file" || true
	done | sed -E 's/^([^:]*:[0-9]+):.*/\1: a fence; put the order on the atomic operation/'
}

# A test that is not registered never fails.
forgotten_tests() {
	find tests -name 'test_*.c' -o -name 'test_*.sh' -o -name 'fuzz_*.c' | sort | while read -r file; do
		name=$(basename "$file")
		list=$(dirname "$file")/CMakeLists.txt
		[ -e "$list" ] || list=tests/CMakeLists.txt
		grep -E "(^|[^a-z0-9_])${name%.*}([^a-z0-9_]|$)" "$list" >/dev/null || echo "$file: $list does not name it"
	done
}

# CI must name every tier that has tests, or a tier that is skipped there would pass.
forgotten_tiers() {
	for tier in unit device window model truth fuzz; do
		find tests -name CMakeLists.txt -exec sed 's/#.*//' {} + | tr '\n' ' ' |
			grep -E "LABELS [^)]*\\b$tier\\b" >/dev/null || continue
		grep -qE "STILB_REQUIRE=[a-z,]*\\b$tier\\b" .ci/run || echo ".ci/run: STILB_REQUIRE does not name the tier $tier"
	done
}

[ -n "$(sources)" ] || { echo "shape.sh: found no source at all"; exit 1; }
violations=$(long_files; header_guards; fences; forgotten_tests; forgotten_tiers)
if [ -n "$violations" ]; then
	printf '%s\n' "$violations"
	exit 1
fi
echo "$(sources | wc -l) files are in shape"
