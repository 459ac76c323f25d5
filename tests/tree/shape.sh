#!/usr/bin/env bash
# shape.sh [ROOT]: checks on the text of the tree. Prints one line per violation; exit 1 if any.
set -euo pipefail
export LC_ALL=C
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "${1:-$here/../..}"

files=$("$here/files.sh" "$PWD")

# these PATTERN [NOT]: the files of the tree whose names match, each ended by a null character.
these() {
	printf '%s\n' "$files" | grep -E "$1" | { [ $# -lt 2 ] && cat || grep -vE "$2"; } | tr '\n' '\0' || true
}

sources='\.([ch]|cpp|hpp|glsl|vert|frag|comp|sh|py)$|(^|/)(dev|CMakeLists.txt)$'
[ -n "$(these "$sources" | tr -d '\0')" ] || { echo "shape.sh: found no source at all"; exit 1; }

# A source file of more than 1,500 lines must be cut in two.
long_files() {
	these "$sources" | xargs -0 awk '
		FNR == 1 { if (last != "" && lines > 1500) print last ": " lines " lines; 1500 is the most" }
		{ last = FILENAME; lines = FNR }
		END { if (lines > 1500) print last ": " lines " lines; 1500 is the most" }'
}

# Lines of more than 120 columns, which clang-format leaves in comments. A tab counts as four columns.
wide_lines() {
	these '\.([ch]|cpp|hpp|glsl|vert|frag|comp)$' | xargs -0 awk '
		length($0) > 105 {
			line = $0
			gsub(/\t/, "    ", line)         # tabs stand only at the beginning of a line
			gsub(/[\200-\277]/, "", line) # the second and later bytes of a character
			if (length(line) > 120) print FILENAME ":" FNR ": " length(line) " columns; 120 is the most"
		}'
}

# Every header has a guard with a name of its own, but for glsl_begin.h and glsl_end.h, which are included several times,
# and job_model_sys.h, which replaces jobs/job_sys.h and so has the same guard.
header_guards() {
	these '\.hpp$|\.h$' '(^|/)(glsl_(begin|end)|job_model_sys)\.h$' | xargs -0 awk '
		function finish() { if (last != "" && state < 2) print last ": does not start with a header guard" }
		FNR == 1 { finish(); last = FILENAME; state = 0 }
		state < 2 && /^[ \t]*#/ {
			if (state == 0 && $1 == "#ifndef") { guard = $2; state = 1 }
			else if (state == 1 && $1 == "#define" && $2 == guard && NF == 2) {
				state = 2
				if (guard in owner) print FILENAME ": the header guard " guard " is also that of " owner[guard]
				else owner[guard] = FILENAME
			} else { print FILENAME ": does not start with a header guard"; state = 3 }
		}
		END { finish() }'
}

# The thread sanitizer does not understand fences: memory orders are arguments of atomic operations.
fences() {
	these '\.([chp]|cpp|hpp)$' | xargs -0 grep -nHE 'atomic_(thread|signal)_fence[[:space:]]*\(|__sync_synchronize' |
		sed -E 's/^([^:]*:[0-9]+):.*/\1: a fence; put the order on the atomic operation/' || true
}

# The dialect of C (CONTRIBUTING.md), as far as a line shows it; strings and comments are no code.
dialect() {
	these '\.[ch]$' '^tests/support/cmocka_small/' | xargs -0 awk '
		function bad(message) { print FILENAME ":" FNR ": " message }
		/^[ \t]*\*( |$)/ { next }
		{ code = $0; gsub(/"([^"\\]|\\.)*"/, "\"\"", code); sub(/\/\*.*/, "", code) }
		code ~ /[!=]= NULL/ { bad("a pointer is tested by itself: p, !p") }
		code ~ /[^A-Za-z0-9_.](0x[0-9a-fA-F]+|[0-9]+)l/ { bad("a suffix L is large: l looks like 1") }
		code ~ /^[ \t]*(\+\+|--)/ || code ~ /; (\+\+|--)[^;]*\)/ { bad("a statement increments behind the name: i++") }
		code ~ /^\t+const ((struct|enum|unsigned|signed|long) )*[a-z0-9_]+ [A-Za-z0-9_]+( =|[;,])/ { bad("a local goes without const") }'
}

# A folder with more than 32 files must be cut into subfolders, but for docs/, whose pictures one command writes into one
# folder.
full_folders() {
	printf '%s\n' "$files" | grep -v '^docs/' | sed 's|[^/]*$||' | sort | uniq -c |
		awk '$1 > 32 { print $2 ": " $1 " files in one folder; 32 are the most" }'
}

# A test that CMakeLists.txt does not name never runs.
forgotten_tests() {
	printf '%s\n' "$files" | grep -E '^tests/(.*/)?(test|fuzz)_[^/]*\.(c|sh)$' | while read -r file; do
		name=${file##*/}
		list=${file%/*}/CMakeLists.txt
		[ -e "$list" ] || list=tests/CMakeLists.txt
		[[ $(<"$list") =~ (^|[^a-z0-9_])${name%.*}([^a-z0-9_]|$) ]] || echo "$file: $list does not name it"
	done
}

# CI must name every tier that has tests: a skipped tier passes unless STILB_REQUIRE names it.
forgotten_tiers() {
	local labels
	labels=$(these '^tests/(.*/)?CMakeLists.txt$' | xargs -0 sed 's/#.*//' | tr '\n' ' ' | grep -oE 'LABELS [^)]*' || true)
	for tier in unit device window model truth fuzz; do
		grep -qE "\\b$tier\\b" <<<"$labels" || continue
		grep -qE "STILB_REQUIRE=[a-z0-9,]*\\b$tier\\b" .ci/run || echo ".ci/run: STILB_REQUIRE does not name the tier $tier"
	done
}

violations=$(long_files; wide_lines; header_guards; fences; dialect; full_folders; forgotten_tests; forgotten_tiers)
if [ -n "$violations" ]; then
	printf '%s\n' "$violations"
	exit 1
fi
echo "$(these "$sources" | tr '\0' '\n' | wc -l) files are in shape"
